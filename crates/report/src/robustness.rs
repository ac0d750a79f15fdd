//! The figure and the page about the robustness of a policy.

use askama::Template;
use task::{RobustnessRow, robustness};

use super::{
    error::ReportError,
    escape::{colours, drawing::Drawing},
    numbers::{count, decimal, percent},
};

/// The robustness of a policy in one scenario.
///
/// # Examples
///
/// ```
/// use report::RobustnessReport;
/// use task::{Evaluation, RobustnessRow};
///
/// let evaluation = Evaluation::new("concave", 1, 200, &[], None);
/// let rows = ["none", "mild", "strong"].map(|level| {
///     let perturbation = if level == "none" { "clean" } else { "all" };
///     RobustnessRow::new(perturbation, level, &evaluation)
/// });
/// let report = RobustnessReport { scenario: "concave", rows: &rows };
/// assert!(report.to_html()?.contains("<h1>concave</h1>"));
/// assert!(report.figure().starts_with("<svg"));
/// # Ok::<(), report::ReportError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct RobustnessReport<'a> {
    /// Name of the scenario.
    pub scenario: &'a str,
    /// The evaluations: one without perturbations first, then two levels of each perturbation.
    pub rows: &'a [RobustnessRow],
}

/// Height of a row of the figure in pixels.
const ROW: f64 = 34.0;
/// y coordinate of the first row.
const TOP: f64 = 84.0;
/// Left edge and width of the panels.
const PANELS: [(f64, f64); 3] = [(300.0, 180.0), (510.0, 180.0), (720.0, 180.0)];
const WIDTH: u32 = 930;

/// A measure that a panel of the figure shows.
struct Measure {
    title: &'static str,
    value: fn(&RobustnessRow) -> Option<f64>,
    /// Whether the axis ends at 100 instead of starting at 0.
    is_rate: bool,
}

const MEASURES: [Measure; 3] = [
    Measure {
        title: "Success rate, %",
        value: |row| Some(100.0 * row.success_rate),
        is_rate: true,
    },
    Measure {
        title: "Blocked per 100 steps",
        value: |row| Some(row.blocked_per_100_steps),
        is_rate: false,
    },
    Measure { title: "Steps to the exit", value: |row| row.mean_steps, is_rate: false },
];

impl RobustnessReport<'_> {
    /// Returns the figure as an SVG file: success rate, blocked moves and steps for each
    /// perturbation and level.
    pub fn figure(&self) -> String {
        let names = self.names();
        let bottom = TOP + ROW * names.len() as f64;
        let mut drawing = Drawing::new(WIDTH, bottom as u32 + 40);
        legend(&mut drawing);
        for (index, name) in names.iter().enumerate() {
            let y = TOP + ROW * (index as f64 + 0.5);
            drawing.text((16.0, y + 5.0), "", label(name));
            for (x, width) in PANELS {
                drawing.add(format_args!(
                    "<line x1='{x}' y1='{y}' x2='{}' y2='{y}' stroke='{}'/>",
                    x + width,
                    colours::GRID
                ));
            }
        }
        for (measure, panel) in MEASURES.iter().zip(PANELS) {
            self.panel(&mut drawing, measure, panel, &names, bottom);
        }
        drawing.finish(
            "Robustness",
            "Success rate, blocked moves and steps under each perturbation of the world",
        )
    }

    /// Returns the names of the perturbations in the order of the rows.
    fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for row in self.rows {
            if !names.contains(&row.perturbation.as_str()) {
                names.push(&row.perturbation);
            }
        }
        names
    }

    fn panel(
        &self,
        drawing: &mut Drawing,
        measure: &Measure,
        (left, width): (f64, f64),
        names: &[&str],
        bottom: f64,
    ) {
        let values = || self.rows.iter().filter_map(measure.value);
        let (low, high) = match measure.is_rate {
            true => (values().fold(99.0, f64::min).floor(), 100.0),
            false => (0.0, ceiling(values().fold(0.0, f64::max))),
        };
        let x_of = |value: f64| left + width * (value - low) / (high - low).max(f64::MIN_POSITIVE);
        let style = "font-size='13' font-weight='600'";
        drawing.text((left, TOP - 16.0), style, measure.title);
        for value in [low, 0.5 * (low + high), high] {
            let attributes =
                format!("font-size='12' text-anchor='middle' fill='{}'", colours::MUTED);
            let digits =
                usize::from((2.0 * value).fract() != 0.0) + usize::from(value.fract() != 0.0);
            drawing.text((x_of(value), bottom + 20.0), &attributes, decimal(value, digits));
            drawing.add(format_args!(
                "<line x1='{x:.1}' y1='{TOP}' x2='{x:.1}' y2='{bottom}' stroke='{}'/>",
                colours::GRID,
                x = x_of(value)
            ));
        }
        let clean = self.rows.iter().find(|row| row.perturbation == robustness::CLEAN);
        if let Some(clean) = clean.and_then(measure.value) {
            drawing.add(format_args!(
                "<line x1='{x:.1}' y1='{TOP}' x2='{x:.1}' y2='{bottom}' stroke='{}' \
                 stroke-dasharray='3 4'/>",
                colours::MUTED,
                x = x_of(clean)
            ));
        }
        for row in self.rows {
            let index = names.iter().position(|name| *name == row.perturbation);
            if let (Some(index), Some(value)) = (index, (measure.value)(row)) {
                let y = TOP + ROW * (index as f64 + 0.5);
                marker(drawing, &row.level, (x_of(value), y));
            }
        }
    }

    /// Returns a self-contained HTML page with the figure and a table.
    ///
    /// # Errors
    ///
    /// Returns an error if the template cannot be rendered.
    pub fn to_html(&self) -> Result<String, ReportError> {
        let cells = |row: &RobustnessRow| {
            let number = |value: Option<f64>| value.map_or("–".to_owned(), |v| decimal(v, 2));
            [
                label(&row.perturbation).to_owned(),
                row.level.clone(),
                percent(row.success_rate),
                decimal(row.blocked_per_100_steps, 2),
                percent(row.collision_free_rate),
                number(row.mean_steps),
                number(row.optimality_ratio),
            ]
        };
        let page = Page {
            scenario: self.scenario,
            episodes: self.rows.first().map_or_else(String::new, |row| count(row.episodes.into())),
            figure: self.figure(),
            rows: self.rows.iter().map(cells).collect(),
        };
        Ok(page.render()?)
    }
}

/// The variables of `templates/robustness.html`.
#[derive(Template)]
#[template(path = "robustness.html")]
struct Page<'a> {
    scenario: &'a str,
    /// Number of episodes of each evaluation.
    episodes: String,
    figure: String,
    rows: Vec<[String; 7]>,
}

/// Returns a perturbation's name for readers.
fn label(name: &str) -> &str {
    match name {
        robustness::CLEAN => "no perturbation",
        robustness::ALL => "all perturbations",
        "camera.noise" => "camera noise",
        "camera.gain_range" => "brightness",
        "camera.color_range" => "white balance",
        "camera.pitch_range, camera.roll_range, camera.yaw_range" => "angles of the mount",
        "camera.height_range, camera.lens_range" => "height of the mount, lens",
        "camera.latency" => "latency of the camera",
        "camera.drop_rate" => "lost images",
        "light.direction_range, surface.color_range" => "light and surfaces",
        "motion.turn_noise, motion.step_noise" => "noise of turns and steps",
        "motion.turn_bias, motion.step_bias" => "bias of turns and steps",
        "motion.blocked" => "motion in blocked moves",
        "odom.noise, odom.drift" => "odometry",
        "obstacles.speed_range" => "speed of obstacles",
        other => other,
    }
}

/// Draws the marker of a level. The markers differ in shape and lightness.
fn marker(drawing: &mut Drawing, level: &str, (x, y): (f64, f64)) {
    match level {
        "strong" => drawing.add(format_args!(
            "<path d='M {x:.1} {} l 7 7 l -7 7 l -7 -7 z' fill='{}'/>",
            y - 7.0,
            colours::OBSTACLE
        )),
        "mild" => drawing.add(format_args!(
            "<circle cx='{x:.1}' cy='{y}' r='5.5' fill='{}' stroke='{}' stroke-width='2'/>",
            colours::PAGE,
            colours::WALL
        )),
        _ => drawing.add(format_args!(
            "<rect x='{:.1}' y='{}' width='10' height='10' fill='{}'/>",
            x - 5.0,
            y - 5.0,
            colours::INK
        )),
    }
}

fn legend(drawing: &mut Drawing) {
    for (level, text, x) in
        [("none", "none", 306.0), ("mild", "mild", 386.0), ("strong", "strong", 466.0)]
    {
        marker(drawing, level, (x, 26.0));
        drawing.text((x + 14.0, 31.0), "", text);
    }
    drawing.text((16.0, 31.0), "font-weight='600'", "Level of the perturbation");
}

/// Returns the smallest of 1, 2, 3, 4, 5, 6, 8, 10, 20, 30, ... that is at least `value`.
fn ceiling(value: f64) -> f64 {
    let mut unit = 1.0;
    while value > 10.0 * unit {
        unit *= 10.0;
    }
    let leading = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0];
    leading.into_iter().map(|digit| digit * unit).find(|end| value <= *end).unwrap_or(10.0 * unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_ends_at_a_round_number_that_is_at_least_the_largest_value() {
        for (value, end) in
            [(0.0, 1.0), (1.0, 1.0), (6.5, 8.0), (9.0, 10.0), (52.1, 60.0), (1587.0, 2000.0)]
        {
            assert_eq!(ceiling(value), end, "{value}");
        }
    }
}
