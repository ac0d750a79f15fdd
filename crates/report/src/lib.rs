//! What a training leaves behind for people: a page to read, and scalars for TensorBoard.
//!
//! [`Report`] is `report.html`, one file that holds everything it shows and needs no network and no
//! script. [`TensorBoard`] writes the same curves while the training runs.

mod axis;
mod chart;
pub mod confidence;
mod curve;
pub mod escape;
mod escape_figures;
mod figures;
mod frame;
mod moving_average;
pub mod numbers;
mod table;
mod tensorboard;

use askama::Template;

pub use self::escape_figures::{EscapeFigure, EscapeFigures};
pub use self::frame::CaptionedFrame;
pub use self::tensorboard::{TensorBoard, TensorBoardError};

use self::chart::PlotError;
use self::figures::Figure;
use self::table::Row;
use learning::record::EpisodeRecord;
use task::Evaluation;

/// A training, ready to be told.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// What was run, and how long it took.
    pub run: RunFacts<'a>,
    /// The episodes so far, in their order; there may be none.
    pub records: &'a [EpisodeRecord],
    /// The greedy test of the policy, once there is one.
    pub evaluation: Option<&'a Evaluation>,
    /// A handful of images from the robot's camera.
    pub frames: &'a [CaptionedFrame],
    /// Pictures of the policy on its way out, if there are any.
    pub escapes: Option<&'a EscapeFigures>,
}

/// The facts of a run, as in `summary.json`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunFacts<'a> {
    /// The scenario trained in.
    pub scenario: &'a str,
    /// The preset that every parameter came from unless it was set.
    pub preset: &'a str,
    /// The seed of the run.
    pub seed: u64,
    /// How many episodes the training has in all; fewer records mean that it was interrupted.
    pub episodes: u32,
    /// Steps of all episodes.
    pub steps: u64,
    /// From the first reset to the last update, in seconds.
    pub wall_s: f64,
    /// `steps / wall_s`.
    pub steps_per_s: f64,
    /// Mean time of one update in microseconds; `None` if there was none.
    pub update_us: Option<f64>,
}

/// The page could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A curve could not be drawn.
    #[error("cannot draw a plot of the report")]
    Plot(#[from] PlotError),
    /// The page around the curves could not be written.
    #[error("cannot fill in the report's page")]
    Page(#[from] askama::Error),
}

impl Report<'_> {
    /// The page: HTML with its styles, plots and images inside.
    pub fn to_html(&self) -> Result<String, ReportError> {
        let page = Page {
            scenario: self.run.scenario,
            lead: self.lead(),
            facts: table::run(&self.run, self.records),
            started: !self.records.is_empty(),
            learning_curve: figures::learning_curve(self.records)?,
            details: figures::details(self.records)?,
            test: self.evaluation.map(table::test),
            escapes: self.escapes.map_or(&[], EscapeFigures::figures),
            animation: self.escapes.and_then(EscapeFigures::animation_uri),
            frames: self.frames.iter().map(|frame| (frame.data_uri(), &*frame.caption)).collect(),
        };
        Ok(page.render()?)
    }

    /// The learning curve, Figure 3 of the paper, as an SVG file; `None` where there is none yet.
    pub fn learning_curve(&self) -> Result<Option<String>, ReportError> {
        let [returns, _] = figures::learning_curve(self.records)?;
        Ok(returns.svg.as_deref().map(chart::standalone))
    }

    /// The result in one sentence.
    fn lead(&self) -> String {
        let episodes = numbers::count(self.records.len() as u64);
        let trained = format!(
            "After {episodes} {} and {} steps of training",
            if self.records.len() == 1 { "episode" } else { "episodes" },
            numbers::count(self.run.steps)
        );
        let Some(test) = self.evaluation.filter(|test| test.episodes > 0) else {
            return format!("{trained}, the policy has not been evaluated yet.");
        };
        let steps = test.mean_steps.map_or_else(String::new, |steps| {
            format!(", in {} steps on average", numbers::decimal(steps, 1))
        });
        format!(
            "{trained}, the robot leaves the room in {} of {} test episodes{steps}.",
            numbers::percent(test.success_rate),
            numbers::count(test.episodes.into()),
        )
    }
}

/// What `templates/report.html` fills in.
#[derive(Template)]
#[template(path = "report.html")]
struct Page<'a> {
    scenario: &'a str,
    lead: String,
    facts: Vec<Row>,
    /// Whether there is a curve to show.
    started: bool,
    learning_curve: [Figure; 2],
    details: [Figure; 4],
    test: Option<Vec<Row>>,
    escapes: &'a [EscapeFigure],
    /// A data URI.
    animation: Option<String>,
    /// (data URI, caption)
    frames: Vec<(String, &'a str)>,
}

#[cfg(test)]
mod tests;
