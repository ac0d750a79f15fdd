//! The camera image: what the robot sees.

use thiserror::Error;

/// A camera image: 20 x 7 pixels, RGB, 8 bits each, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Image(Box<[u8; Image::BYTES]>);

/// A number of bytes that is not that of an image.
#[derive(Debug, Error, PartialEq)]
#[error("an image of {0} bytes: expected 420, 20 x 7 pixels of 3")]
pub struct WrongSize(pub usize);

impl Image {
    /// Pixels in a row.
    pub const WIDTH: usize = 20;
    /// Rows.
    pub const HEIGHT: usize = 7;
    /// Bytes of a pixel: red, green, blue.
    pub const CHANNELS: usize = 3;
    /// Bytes of an image.
    pub const BYTES: usize = Image::WIDTH * Image::HEIGHT * Image::CHANNELS;

    /// The bytes, 0 to 255.
    pub fn bytes(&self) -> &[u8; Image::BYTES] {
        &self.0
    }

    /// The image with left and right exchanged.
    pub fn mirrored(bytes: &[u8; Image::BYTES]) -> [u8; Image::BYTES] {
        let mut mirrored = [0; Image::BYTES];
        let rows = bytes.chunks_exact(3 * Image::WIDTH);
        for (to, from) in mirrored.chunks_exact_mut(3 * Image::WIDTH).zip(rows) {
            for (to, from) in to.chunks_exact_mut(3).zip(from.rchunks_exact(3)) {
                to.copy_from_slice(from);
            }
        }
        mirrored
    }
}

impl TryFrom<Vec<u8>> for Image {
    type Error = WrongSize;

    /// Takes the bytes over, without a copy.
    fn try_from(bytes: Vec<u8>) -> Result<Image, WrongSize> {
        let bytes: Box<[u8; Image::BYTES]> = bytes
            .into_boxed_slice()
            .try_into()
            .map_err(|bytes: Box<[u8]>| WrongSize(bytes.len()))?;
        Ok(Image(bytes))
    }
}

impl TryFrom<&[u8]> for Image {
    type Error = WrongSize;

    fn try_from(bytes: &[u8]) -> Result<Image, WrongSize> {
        let bytes: [u8; Image::BYTES] = bytes.try_into().map_err(|_| WrongSize(bytes.len()))?;
        Ok(Image(Box::new(bytes)))
    }
}
