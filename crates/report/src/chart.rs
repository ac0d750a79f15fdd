//! A plot as an SVG element that uses the colours and the font of the surrounding page.

use std::io;

use plotters::prelude::*;

use super::axis::Axis;

/// The error type of plotters. Drawing to a string is not expected to fail.
pub(super) type PlotError = DrawingAreaErrorKind<io::Error>;

/// Canvas pixels per pixel of the page. plotters rounds coordinates to whole pixels; on a finer
/// canvas, curves are smooth.
const SCALE: u32 = 4;
/// Font size in page pixels.
const FONT_SIZE: u32 = 12;

/// Placeholder colour, CSS variable, and colour on a light page. plotters supports only RGB
/// colours: it draws with placeholders, which are then replaced by CSS variables. The page defines
/// these variables for light and dark mode.
const COLOURS: [(RGBColor, &str, &str); 4] = [
    (LABELS, "var(--muted)", "#646b74"),
    (GRID, "var(--grid)", "#e4e2dd"),
    (POINTS, "var(--points)", "#7d9bb5"),
    (LINE, "var(--line)", "#14568f"),
];

/// Converts an `<svg>` element of the page to an SVG file with the colours of a light page.
pub(super) fn standalone(svg: &str) -> String {
    let light = COLOURS
        .iter()
        .fold(svg.to_owned(), |svg, (_, variable, light)| svg.replace(variable, light));
    let namespace = "<svg xmlns=\"http://www.w3.org/2000/svg\" font-family=\"sans-serif\"";
    light.replacen("<svg", namespace, 1)
}

const LABELS: RGBColor = RGBColor(0, 0, 1);
const GRID: RGBColor = RGBColor(0, 0, 2);
const POINTS: RGBColor = RGBColor(0, 0, 3);
const LINE: RGBColor = RGBColor(0, 0, 4);

/// A plot over the episodes of a training run, with points and a line.
pub(super) struct Chart<'a> {
    /// Width and height in pixels, before the page scales the plot to the available width.
    pub size: (u32, u32),
    /// Text for screen readers.
    pub description: &'a str,
    pub x: Axis,
    pub y: Axis,
    pub y_label: &'a str,
    /// Points as (episode, value). Points outside the range of the axes are not drawn.
    pub points: &'a [(f64, f64)],
    /// Points of the line, in the same format.
    pub line: &'a [(f64, f64)],
}

impl Chart<'_> {
    /// Returns the plot as an `<svg>` element for the page.
    pub fn to_svg(&self) -> Result<String, PlotError> {
        let mut svg = String::new();
        self.draw(&mut svg)?;
        for (RGBColor(red, green, blue), variable, _) in COLOURS {
            svg = svg.replace(&format!("#{red:02X}{green:02X}{blue:02X}"), variable);
        }
        // Replaces the <svg> tag of plotters: in a page, an SVG element needs no namespace, and the
        // style sheet sets its size.
        let body = svg.split_once('>').map_or("", |(_, body)| body);
        let (width, height) = (self.size.0 * SCALE, self.size.1 * SCALE);
        let description = self.description;
        Ok(format!(
            "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{description}\">{body}"
        ))
    }

    fn draw(&self, svg: &mut String) -> Result<(), PlotError> {
        let scaled = |pixels: u32| pixels * SCALE;
        let size = (scaled(self.size.0), scaled(self.size.1));
        let canvas = SVGBackend::with_string(svg, size).into_drawing_area();
        // plotters draws text 1.24 times smaller than the requested size.
        let text_style =
            ("sans-serif", f64::from(scaled(FONT_SIZE)) * 1.24, &LABELS).into_text_style(&canvas);

        let mut chart = ChartBuilder::on(&canvas)
            .margin_top(scaled(FONT_SIZE))
            .margin_right(scaled(2 * FONT_SIZE))
            .x_label_area_size(scaled(44))
            .y_label_area_size(scaled(70))
            .build_cartesian_2d(self.x.clone(), self.y.clone())?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .bold_line_style(GRID.stroke_width(SCALE))
            .axis_style(GRID.stroke_width(SCALE))
            // Also sets the distance of the labels from the axis: twice the length of a tick mark.
            .set_all_tick_mark_size(scaled(3))
            .label_style(text_style)
            .x_desc("Episode")
            .y_desc(self.y_label)
            .draw()?;

        let is_visible = |(x, y): &(f64, f64)| self.x.contains(*x) && self.y.contains(*y);
        let points = self.points.iter().filter(|at| is_visible(at)).copied();
        let radius = scaled(3) / 2;
        chart.draw_series(points.map(|at| Circle::new(at, radius, POINTS.mix(0.6).filled())))?;
        // Interrupts the line where it is outside the plot.
        for line in self.line.split(|at| !is_visible(at)) {
            // A line through a single point would be invisible.
            if let [single] = line {
                chart.draw_series([Circle::new(*single, scaled(3), LINE.filled())])?;
            }
            let line = line.iter().copied();
            chart.draw_series(LineSeries::new(line, LINE.stroke_width(scaled(2))))?;
        }
        canvas.present()
    }
}
