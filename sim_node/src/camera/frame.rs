//! The camera image.

use task::Image;

/// Width of a frame in pixels: 20.
pub const WIDTH: usize = Image::WIDTH;

/// Height of a frame in pixels: 7.
pub const HEIGHT: usize = Image::HEIGHT;

/// Bytes per pixel (red, green, blue): 3.
pub const CHANNELS: usize = Image::CHANNELS;

/// Pixels per frame.
pub(super) const PIXELS: usize = WIDTH * HEIGHT;

/// An image of 20 x 7 pixels in the encoding `rgb8`.
///
/// Holds 420 bytes in row-major order (`[7, 20, 3]`): rows from top to bottom, pixels from left to
/// right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame([u8; Self::LENGTH]);

impl Default for Frame {
    /// Returns a black frame.
    fn default() -> Frame {
        Frame([0; Frame::LENGTH])
    }
}

impl Frame {
    /// Bytes per frame, [`HEIGHT`] x [`WIDTH`] x [`CHANNELS`]: 420.
    pub const LENGTH: usize = PIXELS * CHANNELS;

    /// Returns the bytes for writing.
    pub(crate) fn bytes_mut(&mut self) -> &mut [u8; Self::LENGTH] {
        &mut self.0
    }

    /// Returns the bytes, row-major.
    pub fn bytes(&self) -> &[u8; Self::LENGTH] {
        &self.0
    }

    /// Returns the red, green and blue values of a pixel, 0..=255. Column 0 is the leftmost column,
    /// row 0 the top row.
    ///
    /// # Panics
    ///
    /// Panics unless `column` is below [`WIDTH`] and `row` is below [`HEIGHT`].
    pub fn pixel(&self, column: usize, row: usize) -> [u8; CHANNELS] {
        assert!(
            column < WIDTH && row < HEIGHT,
            "pixel ({column}, {row}) is outside the 20 x 7 frame"
        );
        self.0.as_chunks().0[row * WIDTH + column]
    }
}
