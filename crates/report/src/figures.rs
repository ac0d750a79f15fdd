//! The plots of a training run, with their axes, captions and legends.

use super::axis::Axis;
use super::chart::{Chart, PlotError};
use super::curve::Curve;
use super::moving_average::WINDOW;
use super::numbers;
use learning::record::EpisodeRecord;

/// Maximum number of points per plot. The curves of longer training runs are thinned out, because
/// more points would overlap and make the page large.
const MAX_POINTS: usize = 1000;

/// A plot with its title, caption and legend.
pub(super) struct Figure {
    pub title: &'static str,
    /// `None` if there is no data yet.
    pub svg: Option<String>,
    pub caption: String,
    /// `None` if the plot has only a line or no data.
    pub legend: Option<Legend>,
}

/// The labels of the points and of the line.
pub(super) struct Legend {
    pub points: String,
    pub line: String,
}

/// Returns the plots of return (Figure 3 of the paper) and steps per episode.
pub(super) fn learning_curve(records: &[EpisodeRecord]) -> Result<[Figure; 2], PlotError> {
    let returns = PlotSpec {
        title: "Return per episode",
        y_label: "Return (sum of rewards)",
        caption: "Compare with Figure 3 of the paper. A return closer to zero means that the robot \
                  reached the exit in fewer steps.",
        size: (920, 330),
        y: |curve| Some(Axis::linear(curve.lower_limit()?, curve.extent()?.1)),
    };
    let steps = PlotSpec {
        title: "Steps per episode",
        y_label: "Steps (log scale)",
        caption: "",
        size: (920, 270),
        y: logarithmic,
    };
    Ok([
        returns.figure(Curve::averaged(records, |record| Some(record.episode_return.into())))?,
        steps.figure(Curve::averaged(records, |record| Some(record.steps.max(1).into())))?,
    ])
}

/// Returns the plots of exploration, loss, blocked moves and total steps.
pub(super) fn details(records: &[EpisodeRecord]) -> Result<[Figure; 4], PlotError> {
    let size = (470, 280);
    let epsilon = PlotSpec {
        title: "Exploration",
        y_label: "Probability ε of a random action",
        caption: "",
        size,
        y: from_zero,
    };
    let loss = PlotSpec {
        title: "Loss",
        y_label: "Mean loss (log scale)",
        caption: "The loss grows with the size of the action values. It does not measure success.",
        size,
        y: logarithmic,
    };
    let blocked = PlotSpec {
        title: "Blocked moves",
        y_label: "Blocked moves per 100 steps",
        caption: "Includes blocked random actions; compare with the Exploration plot.",
        size,
        y: from_zero,
    };
    let total = PlotSpec {
        title: "Total steps",
        y_label: "Steps since the start",
        caption: "A flatter curve means fewer steps per episode.",
        size,
        y: from_zero,
    };
    let mut sum = 0.0;
    let running_total = |record: &EpisodeRecord| {
        sum += f64::from(record.steps);
        sum
    };
    Ok([
        epsilon.figure(Curve::exact(records, |record| record.epsilon))?,
        // A logarithmic axis cannot show zero.
        loss.figure(Curve::averaged(records, |record| record.loss.filter(|loss| *loss > 0.0)))?,
        blocked.figure(Curve::blocked(records))?,
        total.figure(Curve::exact(records, running_total))?,
    ])
}

fn from_zero(curve: &Curve) -> Option<Axis> {
    Some(Axis::linear(0.0, curve.extent()?.1))
}

fn logarithmic(curve: &Curve) -> Option<Axis> {
    let (low, high) = curve.extent()?;
    Some(Axis::logarithmic(low, high))
}

/// A plot without its data.
struct PlotSpec {
    title: &'static str,
    y_label: &'static str,
    caption: &'static str,
    /// Width and height in CSS pixels.
    size: (u32, u32),
    /// Returns the y axis for the data, or `None` if there is no data.
    y: fn(&Curve) -> Option<Axis>,
}

impl PlotSpec {
    fn figure(&self, mut curve: Curve) -> Result<Figure, PlotError> {
        let Some((y, (last, _))) = (self.y)(&curve).zip(curve.line.last().copied()) else {
            let caption = "No data yet.".into();
            return Ok(Figure { title: self.title, svg: None, caption, legend: None });
        };
        let below = curve.points.iter().filter(|(_, value)| !y.contains(*value)).count();
        let stride = curve.line.len().div_ceil(MAX_POINTS);
        curve.points = curve.points.into_iter().step_by(stride).collect();
        curve.line = curve.line.into_iter().step_by(stride).collect();

        let legend = (!curve.points.is_empty()).then(|| Legend {
            points: match stride {
                1 => "episode".into(),
                _ => format!("1 of every {stride} episodes"),
            },
            line: format!("mean of the last {WINDOW} episodes"),
        });
        let caption = match below {
            0 => self.caption.to_owned(),
            1 => format!("{} One episode is below the plotted range.", self.caption),
            _ => format!(
                "{} {} episodes are below the plotted range.",
                self.caption,
                numbers::count(below as u64)
            ),
        };
        let svg = Chart {
            size: self.size,
            description: self.title,
            x: Axis::of_episodes(last as u32 + 1, self.size.0 / 90),
            y,
            y_label: self.y_label,
            points: &curve.points,
            line: &curve.line,
        }
        .to_svg()?;
        Ok(Figure { title: self.title, svg: Some(svg), caption, legend })
    }
}
