//! One plot as an SVG element that takes its colours and its letters from the page around it.

use std::io;

use plotters::prelude::*;

use super::axis::Axis;

/// What plotters can fail with; drawing into a string gives it no reason to.
pub(super) type PlotError = DrawingAreaErrorKind<io::Error>;

/// plotters draws at whole pixels. On a canvas this much finer than the page, curves are smooth.
const FINENESS: u32 = 4;
/// The height of the letters, in pixels of the page.
const LETTERS: u32 = 12;

/// An ink is a CSS variable of the page, which knows about light and dark. plotters knows only RGB:
/// it draws with a stand-in, which the variable then replaces. The last is its colour on a light page.
const INKS: [(RGBColor, &str, &str); 4] = [
    (LABELS, "var(--muted)", "#646b74"),
    (GRID, "var(--grid)", "#e4e2dd"),
    (POINTS, "var(--points)", "#7d9bb5"),
    (LINE, "var(--line)", "#14568f"),
];

/// A plot without the page around it: a file of its own.
pub(super) fn standalone(svg: &str) -> String {
    let light = INKS.iter().fold(svg.to_owned(), |svg, (_, ink, light)| svg.replace(ink, light));
    let namespace = "<svg xmlns=\"http://www.w3.org/2000/svg\" font-family=\"sans-serif\"";
    light.replacen("<svg", namespace, 1)
}

const LABELS: RGBColor = RGBColor(0, 0, 1);
const GRID: RGBColor = RGBColor(0, 0, 2);
const POINTS: RGBColor = RGBColor(0, 0, 3);
const LINE: RGBColor = RGBColor(0, 0, 4);

/// Light points and a heavy line over the episodes of a training.
pub(super) struct Chart<'a> {
    /// In pixels of the page, before the page scales it to the room there is.
    pub size: (u32, u32),
    /// What the plot shows, for those who cannot see it.
    pub description: &'a str,
    pub x: Axis,
    pub y: Axis,
    pub y_label: &'a str,
    /// (episode, value). What lies off the axes is not drawn.
    pub points: &'a [(f64, f64)],
    pub line: &'a [(f64, f64)],
}

impl Chart<'_> {
    /// The plot as an `<svg>` element.
    pub fn to_svg(&self) -> Result<String, PlotError> {
        let mut svg = String::new();
        self.draw(&mut svg)?;
        for (RGBColor(red, green, blue), ink, _) in INKS {
            svg = svg.replace(&format!("#{red:02X}{green:02X}{blue:02X}"), ink);
        }
        // Inside a page an SVG element needs no namespace; its size is the style sheet's affair.
        let body = svg.split_once('>').map_or("", |(_, body)| body);
        let (width, height) = (self.size.0 * FINENESS, self.size.1 * FINENESS);
        let description = self.description;
        Ok(format!(
            "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{description}\">{body}"
        ))
    }

    fn draw(&self, svg: &mut String) -> Result<(), PlotError> {
        let fine = |pixels: u32| pixels * FINENESS;
        let size = (fine(self.size.0), fine(self.size.1));
        let canvas = SVGBackend::with_string(svg, size).into_drawing_area();
        // plotters writes letters 1.24 times smaller than it is asked to.
        let letters =
            ("sans-serif", f64::from(fine(LETTERS)) * 1.24, &LABELS).into_text_style(&canvas);

        let mut chart = ChartBuilder::on(&canvas)
            .margin_top(fine(LETTERS))
            .margin_right(fine(2 * LETTERS))
            .x_label_area_size(fine(44))
            .y_label_area_size(fine(70))
            .build_cartesian_2d(self.x.clone(), self.y.clone())?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .bold_line_style(GRID.stroke_width(FINENESS))
            .axis_style(GRID.stroke_width(FINENESS))
            // Labels keep twice the length of a tick away from the axis.
            .set_all_tick_mark_size(fine(3))
            .label_style(letters)
            .x_desc("Episode")
            .y_desc(self.y_label)
            .draw()?;

        let on_the_plot = |(x, y): &&(f64, f64)| self.x.holds(*x) && self.y.holds(*y);
        let points = self.points.iter().filter(on_the_plot).copied();
        let radius = fine(3) / 2;
        chart.draw_series(points.map(|at| Circle::new(at, radius, POINTS.mix(0.6).filled())))?;
        let line: Vec<_> = self.line.iter().filter(on_the_plot).copied().collect();
        if let [alone] = line[..] {
            chart.draw_series([Circle::new(alone, fine(3), LINE.filled())])?;
        }
        chart.draw_series(LineSeries::new(line, LINE.stroke_width(fine(2))))?;
        canvas.present()
    }
}
