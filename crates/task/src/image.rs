//! The camera image.

use thiserror::Error;

/// A camera image of 20 x 7 RGB pixels with 8 bits per channel.
///
/// The bytes have the shape `[7, 20, 3]` in row-major order: rows from top to bottom, pixels from
/// left to right, channels in the order red, green, blue. This is the layout of a
/// `sensor_msgs/msg/Image` with encoding `rgb8` and a `step` of 60 bytes.
///
/// # Examples
///
/// ```
/// use task::Image;
///
/// let image = Image::try_from(vec![128u8; Image::BYTES])?;
/// assert_eq!(image.bytes().len(), 420);
///
/// let error = Image::try_from(vec![128u8; 3]).unwrap_err();
/// assert_eq!(error.to_string(), "image: invalid size of 3 bytes (expected: 420 = 20 x 7 x 3)");
/// # Ok::<(), task::image::InvalidImageSize>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Image(Box<[u8; Image::BYTES]>);

/// The error for a buffer whose length, in bytes, is not [`Image::BYTES`].
#[derive(Debug, Error, PartialEq)]
#[error("image: invalid size of {0} bytes (expected: 420 = 20 x 7 x 3)")]
pub struct InvalidImageSize(pub usize);

impl Image {
    /// Pixels per row.
    pub const WIDTH: usize = 20;
    /// Number of rows.
    pub const HEIGHT: usize = 7;
    /// Bytes per pixel: one each for red, green and blue.
    pub const CHANNELS: usize = 3;
    /// Bytes per image.
    pub const BYTES: usize = Image::WIDTH * Image::HEIGHT * Image::CHANNELS;

    /// Returns the bytes, in the shape `[7, 20, 3]`.
    pub fn bytes(&self) -> &[u8; Image::BYTES] {
        &self.0
    }

    /// Returns a copy of the bytes of an image, mirrored left to right.
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
    type Error = InvalidImageSize;

    /// Takes ownership of the bytes without copying them.
    ///
    /// # Errors
    ///
    /// Returns [`InvalidImageSize`] if there are not exactly [`Image::BYTES`] bytes.
    fn try_from(bytes: Vec<u8>) -> Result<Image, InvalidImageSize> {
        let bytes: Box<[u8; Image::BYTES]> = bytes
            .into_boxed_slice()
            .try_into()
            .map_err(|bytes: Box<[u8]>| InvalidImageSize(bytes.len()))?;
        Ok(Image(bytes))
    }
}

impl TryFrom<&[u8]> for Image {
    type Error = InvalidImageSize;

    /// Copies the bytes.
    ///
    /// # Errors
    ///
    /// Returns [`InvalidImageSize`] if there are not exactly [`Image::BYTES`] bytes.
    fn try_from(bytes: &[u8]) -> Result<Image, InvalidImageSize> {
        let bytes: [u8; Image::BYTES] =
            bytes.try_into().map_err(|_| InvalidImageSize(bytes.len()))?;
        Ok(Image(Box::new(bytes)))
    }
}
