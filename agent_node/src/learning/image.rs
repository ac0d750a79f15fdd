//! What the robot sees.

use thiserror::Error;

/// A camera image: 20 x 7 pixels, RGB, 8 bits each, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image(Box<[u8; Image::BYTES]>);

/// Why bytes are no image.
#[derive(Debug, Error, PartialEq)]
#[error("an image of {0} bytes: expected 420, 20 x 7 pixels of 3")]
pub struct WrongSize(pub usize);

impl Image {
    /// Pixels in a row.
    pub const WIDTH: usize = 20;
    /// Rows.
    pub const HEIGHT: usize = 7;
    /// Bytes of an image, and inputs of a network that sees one.
    pub const BYTES: usize = Image::WIDTH * Image::HEIGHT * 3;

    /// The bytes, 0 to 255.
    pub fn bytes(&self) -> &[u8; Image::BYTES] {
        &self.0
    }

    /// Writes the image as a network's input: every byte divided by 255.
    #[inline(always)]
    pub fn write_input(bytes: &[u8], input: &mut [f32]) {
        for (value, byte) in input.iter_mut().zip(bytes) {
            *value = f32::from(*byte) * (1.0 / 255.0);
        }
    }
}

impl TryFrom<&[u8]> for Image {
    type Error = WrongSize;

    fn try_from(bytes: &[u8]) -> Result<Image, WrongSize> {
        let bytes: [u8; Image::BYTES] = bytes.try_into().map_err(|_| WrongSize(bytes.len()))?;
        Ok(Image(Box::new(bytes)))
    }
}
