//! Enlarged camera images.

use task::Image;

use super::drawing::Drawing;

/// Draws an image with its upper left corner at (x, y). `pixel` is the size of an image pixel in
/// pixels of the drawing.
///
/// The image is drawn as rectangles, because some viewers smooth embedded images.
pub(super) fn camera(drawing: &mut Drawing, image: &Image, (x, y): (f64, f64), pixel: f64) {
    let attributes = format_args!(
        "class='camera' transform='translate({x:.1} {y:.1}) scale({pixel:.3})' \
         shape-rendering='crispEdges'"
    );
    drawing.group(attributes, |drawing| {
        let rows = image.bytes().chunks_exact(3 * Image::WIDTH);
        for (row, bytes) in rows.enumerate() {
            let pixels: Vec<&[u8]> = bytes.chunks_exact(3).collect();
            let mut column = 0;
            // Adjacent pixels of the same colour become one rectangle.
            for run in pixels.chunk_by(|left, right| left == right) {
                let (colour, width) = (hexadecimal(run[0]), run.len());
                drawing.add(format_args!(
                    "<rect x='{column}' y='{row}' width='{width}' height='1' fill='{colour}'/>"
                ));
                column += width;
            }
        }
    });
}

/// Formats red, green and blue as "#rrggbb".
pub(super) fn hexadecimal(rgb: &[u8]) -> String {
    rgb.iter().fold("#".to_owned(), |colour, byte| format!("{colour}{byte:02x}"))
}
