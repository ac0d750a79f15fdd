//! The colours of the figures. The colours of the page are those of `report.html` in light mode.
//! The room has the colours of the simulator (blue, green, red), in shades that also differ in
//! lightness, for readers who cannot distinguish red from green.

pub(crate) const PAGE: &str = "#fcfbf9";
pub(crate) const INK: &str = "#22262b";
pub(crate) const MUTED: &str = "#646b74";
pub(crate) const GRID: &str = "#e4e2dd";

pub(crate) const WALL: &str = "#2f6ea8";
pub(crate) const EXIT: &str = "#4cbf8b";
pub(crate) const OBSTACLE: &str = "#bd3a32";
/// The trail of a moving obstacle.
pub(crate) const TRAIL: &str = "#7a1f1a";

/// Colours of paths, different from the colours of the room.
const PATHS: [&str; 5] = [INK, "#8f4fc4", "#cc8400", "#48a2d8", "#8a6a58"];

/// Returns the colour of the path with this index. The colours repeat after the last one.
pub(crate) fn path(index: usize) -> &'static str {
    PATHS[index % PATHS.len()]
}
