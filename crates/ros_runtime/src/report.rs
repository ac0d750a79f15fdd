//! The diagnostic report of a component.

/// The level of a report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Level {
    /// The component works.
    #[default]
    Ok,
    /// The component works, but needs attention.
    Warn,
    /// The component does not work.
    Error,
    /// The component has not been updated recently.
    Stale,
}

/// The status of a component.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// The level.
    pub level: Level,
    /// A short description.
    pub message: String,
    /// Details: pairs of a key, with its unit (such as `rate, 1/s`), and a value.
    pub values: Vec<(&'static str, String)>,
}
