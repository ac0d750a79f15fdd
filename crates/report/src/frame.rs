//! Camera images that are embedded in the page.

use base64::{Engine, prelude::BASE64_STANDARD};
use task::Image;

/// A camera image with its caption.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CaptionedFrame {
    /// The camera image.
    pub image: Image,
    /// Caption, e.g. "Evaluation episode 7; first action: 45° to the left".
    pub caption: String,
}

impl CaptionedFrame {
    /// Returns the image as a PNG file in a `data:` URI.
    pub(super) fn data_uri(&self) -> String {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, Image::WIDTH as u32, Image::HEIGHT as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder
            .write_header()
            .and_then(|mut writer| writer.write_image_data(self.image.bytes()))
            .expect("the image has the declared size, and writing to memory cannot fail");
        format!("data:image/png;base64,{}", BASE64_STANDARD.encode(file))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_data_uri_decodes_to_the_image() {
        let bytes: Vec<u8> = (0..Image::BYTES).map(|index| (7 * index % 256) as u8).collect();
        let image = Image::try_from(&bytes[..]).unwrap();
        let caption = String::new();
        let uri = CaptionedFrame { image, caption }.data_uri();

        let base64 = uri.strip_prefix("data:image/png;base64,").unwrap();
        let file = BASE64_STANDARD.decode(base64).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();

        assert_eq!((info.width, info.height), (20, 7));
        assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
        assert_eq!(pixels, bytes);
    }
}
