//! Reports on training runs: an HTML page, figures, and TensorBoard event files.
//!
//! [`Report`] generates `report.html`, a self-contained page without scripts. [`TensorBoard`]
//! writes the same curves during training. [`RobustnessReport`] shows how perturbations of the world
//! affect a policy. [`escape`] draws a policy's escapes.
//!
//! # Examples
//!
//! ```
//! use report::{Report, RunSummary};
//!
//! let run = RunSummary {
//!     scenario: "empty",
//!     preset: "robust",
//!     seed: 0,
//!     episodes: 9000,
//!     steps: 41_000,
//!     wall_s: 9.5,
//!     steps_per_s: 4315.8,
//!     update_us: Some(93.0),
//! };
//! let report = Report { run, records: &[], evaluation: None, frames: &[], escapes: None };
//! assert!(report.to_html()?.contains("<h1>empty</h1>"));
//! # Ok::<(), report::ReportError>(())
//! ```

mod axis;
mod chart;
pub mod confidence;
mod curve;
mod error;
pub mod escape;
mod escape_figures;
mod figures;
mod frame;
mod moving_average;
pub mod numbers;
mod robustness;
mod run_summary;
mod table;
mod tensorboard;

use askama::Template;

pub use self::error::ReportError;
pub use self::escape_figures::{EscapeFigure, EscapeFigures};
pub use self::frame::CaptionedFrame;
pub use self::robustness::RobustnessReport;
pub use self::run_summary::RunSummary;
pub use self::tensorboard::{TensorBoard, TensorBoardError};

use self::figures::Figure;
use self::table::Row;
use learning::record::EpisodeRecord;
use task::Evaluation;

/// The content of a training run's report.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// Configuration and duration of the run.
    pub run: RunSummary<'a>,
    /// The completed training episodes, in the order in which they ended; may be empty.
    pub records: &'a [EpisodeRecord],
    /// The evaluation of the policy; `None` if it has not been evaluated yet.
    pub evaluation: Option<&'a Evaluation>,
    /// Camera images of the evaluation; may be empty.
    pub frames: &'a [CaptionedFrame],
    /// Figures of escapes; `None` if there are none.
    pub escapes: Option<&'a EscapeFigures>,
}

impl Report<'_> {
    /// Returns the page as HTML, with an embedded style sheet, plots and images.
    ///
    /// # Errors
    ///
    /// Returns [`ReportError`] if a plot cannot be drawn or the page cannot be rendered.
    pub fn to_html(&self) -> Result<String, ReportError> {
        let page = Page {
            scenario: self.run.scenario,
            lead: self.lead(),
            facts: table::run_rows(&self.run, self.records),
            has_episodes: !self.records.is_empty(),
            learning_curve: figures::learning_curve(self.records)?,
            details: figures::details(self.records)?,
            evaluation: self.evaluation.map(table::evaluation_rows),
            escapes: self.escapes.map_or(&[], EscapeFigures::figures),
            animation: self.escapes.and_then(EscapeFigures::animation_uri),
            frames: self.frames.iter().map(|frame| (frame.data_uri(), &*frame.caption)).collect(),
        };
        Ok(page.render()?)
    }

    /// Returns the learning curve (Figure 3 of the paper) as an SVG file, or `None` if no episode
    /// has ended yet.
    ///
    /// # Errors
    ///
    /// Returns [`ReportError::Plot`] if the curve cannot be drawn.
    pub fn learning_curve(&self) -> Result<Option<String>, ReportError> {
        let [returns, _] = figures::learning_curve(self.records)?;
        Ok(returns.svg.as_deref().map(chart::standalone))
    }

    /// Returns a short summary of the result.
    fn lead(&self) -> String {
        let episodes = numbers::count(self.records.len() as u64);
        let trained = format!(
            "{episodes} {} ({} steps)",
            if self.records.len() == 1 { "episode" } else { "episodes" },
            numbers::count(self.run.steps)
        );
        let Some(evaluation) = self.evaluation.filter(|evaluation| evaluation.episodes > 0) else {
            return format!("Trained for {trained}. The policy has not been evaluated yet.");
        };
        let steps = evaluation.mean_steps.map_or_else(String::new, |steps| {
            format!(", in {} steps on average", numbers::decimal(steps, 1))
        });
        format!(
            "After {trained} of training, the robot reaches the exit in {} of {} evaluation \
             episodes{steps}.",
            numbers::percent(evaluation.success_rate),
            numbers::count(evaluation.episodes.into()),
        )
    }
}

/// The variables of `templates/report.html`.
#[derive(Template)]
#[template(path = "report.html")]
struct Page<'a> {
    scenario: &'a str,
    lead: String,
    facts: Vec<Row>,
    has_episodes: bool,
    learning_curve: [Figure; 2],
    details: [Figure; 4],
    evaluation: Option<Vec<Row>>,
    escapes: &'a [EscapeFigure],
    /// `data:` URI of a GIF.
    animation: Option<String>,
    /// (`data:` URI, caption)
    frames: Vec<(String, &'a str)>,
}

#[cfg(test)]
mod tests;
