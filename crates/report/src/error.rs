//! Errors of reports.

use super::chart::PlotError;

/// The error returned if a report cannot be generated.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A plot cannot be drawn.
    #[error("cannot draw a plot of the report")]
    Plot(#[from] PlotError),
    /// The template of the page cannot be rendered.
    #[error("cannot render the page of the report")]
    Page(#[from] askama::Error),
}
