//! The image that the camera makes.

use task::Image;

/// Pixels in a row.
pub const WIDTH: usize = Image::WIDTH;

/// Rows.
pub const HEIGHT: usize = Image::HEIGHT;

/// Bytes of a pixel: red, green, blue.
pub const CHANNELS: usize = Image::CHANNELS;

/// Pixels in a frame.
pub(super) const PIXELS: usize = WIDTH * HEIGHT;

/// An image of 20 x 7 pixels: 420 bytes `rgb8`, row by row from the top, each row from the left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame([u8; Self::LENGTH]);

/// A black one.
impl Default for Frame {
    fn default() -> Frame {
        Frame([0; Frame::LENGTH])
    }
}

impl Frame {
    /// Bytes in a frame: [`HEIGHT`] x [`WIDTH`] x [`CHANNELS`].
    pub const LENGTH: usize = PIXELS * CHANNELS;

    /// The bytes, to be drawn on.
    pub(super) fn bytes_mut(&mut self) -> &mut [u8; Self::LENGTH] {
        &mut self.0
    }

    /// The bytes.
    pub fn bytes(&self) -> &[u8; Self::LENGTH] {
        &self.0
    }

    /// The red, green and blue of a pixel; the first column is the left one, the first row the
    /// upper one.
    ///
    /// # Panics
    ///
    /// If the column is not below [`WIDTH`] or the row not below [`HEIGHT`].
    pub fn pixel(&self, column: usize, row: usize) -> [u8; CHANNELS] {
        assert!(column < WIDTH && row < HEIGHT, "no pixel ({column}, {row}) in 20 x 7");
        self.0.as_chunks().0[row * WIDTH + column]
    }
}
