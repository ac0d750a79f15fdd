//! Converts an image to network inputs.

use task::Image;

/// Writes the bytes of an image, `[420]`, divided by 255, to `input`.
#[inline(always)]
pub fn write_image(bytes: &[u8; Image::BYTES], input: &mut [f32; Image::BYTES]) {
    // Division is slow; a multiplication and one correction give the same quotient to the last bit.
    const RECIPROCAL: f32 = 1.0 / 255.0;
    for (value, byte) in input.iter_mut().zip(bytes) {
        let byte = f32::from(*byte);
        let quotient = byte * RECIPROCAL;
        *value = quotient.mul_add(-255.0, byte).mul_add(RECIPROCAL, quotient);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn divides_every_byte_by_255() {
        for byte in 0..=255 {
            let mut input = [0.0; Image::BYTES];
            write_image(&[byte; Image::BYTES], &mut input);
            assert_eq!(input, [f32::from(byte) / 255.0; Image::BYTES]);
        }
    }
}
