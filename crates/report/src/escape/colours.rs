//! The colours of the pictures. Those of the page are `report.html`'s in daylight; those of the
//! room are the simulator's, blue, green and red, in shades that differ in lightness too, so that
//! one need not tell red from green.

pub(super) const PAGE: &str = "#fcfbf9";
pub(super) const INK: &str = "#22262b";
pub(super) const MUTED: &str = "#646b74";
pub(super) const GRID: &str = "#e4e2dd";

pub(super) const WALL: &str = "#2f6ea8";
pub(super) const EXIT: &str = "#4cbf8b";
pub(super) const OBSTACLE: &str = "#bd3a32";
/// On an obstacle, and where it came from.
pub(super) const TRAIL: &str = "#7a1f1a";

/// Paths, in the order in which they are given out. None of them is red, green or the walls' blue.
const PATHS: [&str; 5] = [INK, "#8f4fc4", "#cc8400", "#48a2d8", "#8a6a58"];

/// The colour of a path; after the last colour comes the first.
pub(super) fn path(index: usize) -> &'static str {
    PATHS[index % PATHS.len()]
}
