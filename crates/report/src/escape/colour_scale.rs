//! The colour scale of the Q-values.

use super::camera::hexadecimal;
use super::colours;
use super::drawing::Drawing;
use crate::numbers::decimal;

/// Evenly spaced colours from matplotlib's colour map "viridis". Their lightness increases
/// steadily, even in greyscale and for readers with colour blindness.
const VIRIDIS: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 45, 123],
    [59, 82, 139],
    [44, 114, 142],
    [33, 145, 140],
    [40, 174, 128],
    [94, 201, 98],
    [173, 220, 48],
    [253, 231, 37],
];

/// A mapping from values to colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ColourScale {
    low: f64,
    high: f64,
}

impl ColourScale {
    /// Returns the scale from the smallest to the largest finite value, with a margin of 0.1 if
    /// they are equal, or from -1 to 0 if no value is finite.
    pub fn of<'a>(values: impl IntoIterator<Item = &'a f32>) -> Self {
        let finite = values.into_iter().map(|value| f64::from(*value)).filter(|v| v.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        match (low, high) {
            (low, high) if low < high => Self { low, high },
            (low, high) if low == high => Self { low: low - 0.1, high: high + 0.1 },
            _ => Self { low: -1.0, high: 0.0 },
        }
    }

    /// Returns the colour of a value as "#rrggbb"; grey if the value is not finite.
    pub fn colour(&self, value: f32) -> String {
        let share = (f64::from(value) - self.low) / (self.high - self.low);
        if share.is_finite() { viridis(share) } else { colours::GRID.to_owned() }
    }

    /// Draws the scale as a horizontal bar with three values below it.
    pub fn bar(&self, drawing: &mut Drawing, (x, y): (f64, f64), width: f64) {
        const PIECES: u32 = 64;
        for piece in 0..PIECES {
            let share = f64::from(piece) / f64::from(PIECES);
            let colour = viridis(share + 0.5 / f64::from(PIECES));
            // To avoid seams, each piece extends to the end of the bar; the next is drawn over it.
            drawing.add(format_args!(
                "<rect x='{:.2}' y='{y:.1}' width='{:.2}' height='12' fill='{colour}'/>",
                x + share * width,
                width * (1.0 - share)
            ));
        }
        for (share, anchor) in [(0.0, "start"), (0.5, "middle"), (1.0, "end")] {
            let label = decimal(self.low + share * (self.high - self.low), 2);
            let attributes =
                format!("font-size='13' fill='{}' text-anchor='{anchor}'", colours::MUTED);
            drawing.text((x + share * width, y + 28.0), &attributes, label);
        }
    }
}

/// Returns the colour at the position `share` of the scale, 0 to 1.
fn viridis(share: f64) -> String {
    let position = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let below = (position as usize).min(VIRIDIS.len() - 2);
    let [low, high] = [VIRIDIS[below], VIRIDIS[below + 1]];
    let part = position - below as f64;
    let mixed = [0, 1, 2].map(|channel| {
        let [low, high] = [low, high].map(|colour| f64::from(colour[channel]));
        (low + part * (high - low)).round() as u8
    });
    hexadecimal(&mixed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_value_is_darkest_and_the_largest_lightest() {
        let scale = ColourScale::of(&[-0.5, -2.0, f32::NAN, -1.0]);
        assert_eq!(scale.colour(-2.0), "#440154");
        assert_eq!(scale.colour(-1.25), "#21918c");
        assert_eq!(scale.colour(-0.5), "#fde725");
        assert_eq!(scale.colour(f32::NAN), colours::GRID);
    }

    #[test]
    fn equal_or_missing_values_have_a_scale() {
        assert_eq!(ColourScale::of(&[-1.0; 7]).colour(-1.0), "#21918c");
        assert_eq!(ColourScale::of(&[f32::NAN]), ColourScale::of(&[]));
        assert_eq!(ColourScale::of(&[f32::INFINITY]).colour(-2.0), "#440154");
    }
}
