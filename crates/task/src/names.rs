//! Values that are selected by name.

use std::fmt::Display;

use thiserror::Error;

/// The error for a name that a setting does not have.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{setting}: unknown value '{name}' (expected: {expected})")]
pub struct UnknownName {
    setting: &'static str,
    name: String,
    /// The valid names, separated by commas.
    expected: String,
}

/// Returns the value that is displayed as `name`, among `all` values of a setting.
///
/// # Errors
///
/// Returns an error that lists all names if there is none.
///
/// # Examples
///
/// ```
/// use task::names::find;
///
/// assert_eq!(find("gear", [1, 2, 3], "2"), Ok(2));
/// let error = find("gear", [1, 2, 3], "5").unwrap_err();
/// assert_eq!(error.to_string(), "gear: unknown value '5' (expected: 1, 2, 3)");
/// ```
pub fn find<T: Copy + Display, const N: usize>(
    setting: &'static str,
    all: [T; N],
    name: &str,
) -> Result<T, UnknownName> {
    all.into_iter().find(|value| value.to_string() == name).ok_or_else(|| UnknownName {
        setting,
        name: name.to_owned(),
        expected: all.map(|value| value.to_string()).join(", "),
    })
}
