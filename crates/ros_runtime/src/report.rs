//! How a part of a node is.

/// How well a part does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Level {
    /// All is well.
    #[default]
    Ok,
    /// It works, but needs attention.
    Warn,
    /// It does not work.
    Error,
    /// There was no update for a while.
    Stale,
}

/// How a part is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// How well.
    pub level: Level,
    /// In a few words.
    pub message: String,
    /// The same in numbers: what, with its unit, and how much.
    pub values: Vec<(&'static str, String)>,
}
