//! The palette of a GIF frame.

use std::collections::HashMap;

/// Index of a pixel that is unchanged since the previous frame. No colour has this index.
pub(super) const UNCHANGED: u8 = 255;

/// The most frequent colours of a frame, in descending order of frequency.
///
/// The colours of uniform areas are therefore exact and do not flicker between frames. Only pixels
/// at edges are approximated.
pub(super) struct Palette(Vec<[u8; 3]>);

impl Palette {
    /// Returns the palette of a frame: its 255 most frequent colours, or all of them if there are
    /// fewer.
    pub fn of(pixels: &[[u8; 3]]) -> Self {
        let mut counts = HashMap::<[u8; 3], usize>::new();
        for pixel in pixels {
            *counts.entry(*pixel).or_default() += 1;
        }
        let mut counts: Vec<_> = counts.into_iter().collect();
        // Also sorted by colour, because the iteration order of a hash map is not reproducible.
        counts.sort_unstable_by_key(|(colour, count)| (usize::MAX - count, *colour));
        let colours = counts.into_iter().map(|(colour, _)| colour);
        Self(colours.take(UNCHANGED.into()).collect())
    }

    /// Returns the palette as 256 x 3 bytes (red, green, blue). Unused entries are black, as is the
    /// entry for [`UNCHANGED`].
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = self.0.as_flattened().to_vec();
        bytes.resize(3 * 256, 0);
        bytes
    }

    /// Returns the palette index of each pixel's colour or of the nearest one, or [`UNCHANGED`] if
    /// the pixel is the same as in the previous frame. `previous` is empty for the first frame.
    pub fn indices(&self, pixels: &[[u8; 3]], previous: &[[u8; 3]]) -> Vec<u8> {
        let exact = self.0.iter().zip(0..UNCHANGED).map(|(colour, index)| (*colour, index));
        let mut known: HashMap<[u8; 3], u8> = exact.collect();
        let index = |(position, pixel): (usize, &[u8; 3])| match previous.get(position) {
            Some(same) if same == pixel => UNCHANGED,
            _ => *known.entry(*pixel).or_insert_with(|| self.nearest(*pixel)),
        };
        pixels.iter().enumerate().map(index).collect()
    }

    fn nearest(&self, pixel: [u8; 3]) -> u8 {
        let distance = |colour: &[u8; 3]| -> u32 {
            colour.iter().zip(pixel).map(|(one, other)| u32::from(one.abs_diff(other)).pow(2)).sum()
        };
        let colours = self.0.iter().zip(0..UNCHANGED);
        colours.min_by_key(|(colour, _)| distance(colour)).map_or(0, |(_, index)| index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequent_colours_are_exact_and_others_approximated() {
        let background = [[250, 250, 250]; 1000];
        let shades = (0..300_u16).map(|shade| [(shade / 2) as u8, (shade % 2) as u8, 9]);
        let pixels: Vec<_> = background.into_iter().chain(shades).collect();
        let palette = Palette::of(&pixels);
        let indices = palette.indices(&pixels, &[]);
        assert_eq!(indices[..1000], [0; 1000]);
        let colours = palette.bytes();
        for (pixel, index) in pixels.iter().zip(indices) {
            let colour = &colours[3 * usize::from(index)..][..3];
            let off = pixel.iter().zip(colour).map(|(one, other)| one.abs_diff(*other)).max();
            // The palette lacks the last 46 shades.
            assert!(index != UNCHANGED && off <= Some(23), "{pixel:?} as {colour:?}");
        }
    }

    #[test]
    fn unchanged_pixels_have_their_own_index() {
        let palette = Palette::of(&[[1, 2, 3], [4, 5, 6], [4, 5, 6]]);
        assert_eq!(palette.bytes()[..6], [4, 5, 6, 1, 2, 3]);
        let indices = palette.indices(&[[1, 2, 3], [4, 5, 6]], &[[1, 2, 3], [1, 2, 3]]);
        assert_eq!(indices, [UNCHANGED, 0]);
    }
}
