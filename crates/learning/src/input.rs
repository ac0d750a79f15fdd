//! An image as a network's input.

use task::Image;

/// Writes an image as a network's input: every byte divided by 255.
#[inline(always)]
pub fn write_image(bytes: &[u8; Image::BYTES], input: &mut [f32; Image::BYTES]) {
    // Division is slow; a product and its correction give the same quotient to the last bit.
    const SHARE: f32 = 1.0 / 255.0;
    for (value, byte) in input.iter_mut().zip(bytes) {
        let byte = f32::from(*byte);
        let quotient = byte * SHARE;
        *value = quotient.mul_add(-255.0, byte).mul_add(SHARE, quotient);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_input_is_the_byte_divided_by_255() {
        for byte in 0..=255 {
            let mut input = [0.0; Image::BYTES];
            write_image(&[byte; Image::BYTES], &mut input);
            assert_eq!(input, [f32::from(byte) / 255.0; Image::BYTES]);
        }
    }
}
