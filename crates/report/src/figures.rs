//! The plots of a training: what is drawn, on which axes, and what is said about it.

use super::axis::Axis;
use super::chart::{Chart, PlotError};
use super::curve::Curve;
use super::moving_average::WINDOW;
use super::numbers;
use learning::record::EpisodeRecord;

/// More points than this are a stain and a heavy page: then one episode in so many is drawn.
const MAX_POINTS: usize = 1000;

/// A plot and the words around it.
pub(super) struct Figure {
    pub title: &'static str,
    /// `None` where there is nothing to draw yet.
    pub svg: Option<String>,
    pub caption: String,
    /// What the points and the line are, where there are both.
    pub legend: Option<Legend>,
}

/// The words beside a point and beside a piece of the line.
pub(super) struct Legend {
    pub points: String,
    pub line: String,
}

/// The return of the episodes, Figure 3 of the paper, and their steps.
pub(super) fn learning_curve(records: &[EpisodeRecord]) -> Result<[Figure; 2], PlotError> {
    let returns = Sketch {
        title: "Return per episode",
        y_label: "Return (sum of the rewards)",
        caption: "The learning curve, Figure 3 of the paper. The closer to zero, the faster the \
                  robot was out.",
        size: (920, 330),
        y: |curve| Some(Axis::linear(curve.floor_of_the_bulk()?, curve.extent()?.1)),
    };
    let steps = Sketch {
        title: "Steps per episode",
        y_label: "Steps (logarithmic)",
        caption: "",
        size: (920, 270),
        y: logarithmic,
    };
    Ok([
        returns.figure(Curve::averaged(records, |record| Some(record.episode_return.into())))?,
        steps.figure(Curve::averaged(records, |record| Some(record.steps.max(1).into())))?,
    ])
}

/// Exploration, loss, blocked moves and the steps so far: what went on beneath the learning curve.
pub(super) fn details(records: &[EpisodeRecord]) -> Result<[Figure; 4], PlotError> {
    let size = (470, 280);
    let epsilon = Sketch {
        title: "Exploration",
        y_label: "Probability ε of a random action",
        caption: "",
        size,
        y: from_zero,
    };
    let loss = Sketch {
        title: "Loss",
        y_label: "Mean loss (logarithmic)",
        caption: "",
        size,
        y: logarithmic,
    };
    let blocked = Sketch {
        title: "Blocked moves",
        y_label: "Blocked moves per 100 steps",
        caption: "Random actions are blocked too: read this beside the exploration.",
        size,
        y: from_zero,
    };
    let total = Sketch {
        title: "Experience",
        y_label: "Steps so far",
        caption: "The flatter the curve, the fewer steps an episode takes.",
        size,
        y: from_zero,
    };
    let mut so_far = 0.0;
    let running_total = |record: &EpisodeRecord| {
        so_far += f64::from(record.steps);
        so_far
    };
    Ok([
        epsilon.figure(Curve::exact(records, |record| record.epsilon))?,
        // A logarithmic axis has no zero.
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

/// A plot before its data.
struct Sketch {
    title: &'static str,
    y_label: &'static str,
    caption: &'static str,
    size: (u32, u32),
    y: fn(&Curve) -> Option<Axis>,
}

impl Sketch {
    fn figure(&self, mut curve: Curve) -> Result<Figure, PlotError> {
        let Some((y, (last, _))) = (self.y)(&curve).zip(curve.line.last().copied()) else {
            let caption = "Nothing to draw yet.".into();
            return Ok(Figure { title: self.title, svg: None, caption, legend: None });
        };
        let below = curve.points.iter().filter(|(_, value)| !y.holds(*value)).count();
        let stride = curve.line.len().div_ceil(MAX_POINTS);
        curve.points = curve.points.into_iter().step_by(stride).collect();
        curve.line = curve.line.into_iter().step_by(stride).collect();

        let legend = (!curve.points.is_empty()).then(|| Legend {
            points: match stride {
                1 => "each episode".into(),
                _ => format!("one episode in {stride}"),
            },
            line: format!("mean of the last {WINDOW}"),
        });
        let caption = match below {
            0 => self.caption.to_owned(),
            1 => format!("{} One episode lies below the plot.", self.caption),
            _ => format!(
                "{} {} episodes lie below the plot.",
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
