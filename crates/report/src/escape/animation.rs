//! An escape as a short film.

use std::borrow::Cow;

use gif::{Encoder, Frame, Repeat};
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg;
use task::Image;

use super::camera::camera;
use super::colour_scale::ColourScale;
use super::colours::{EXIT, GRID, INK, MUTED, PAGE};
use super::drawing::Drawing;
use super::palette::{self, Palette};
use super::preference::{Compass, full_ring};
use super::{Escape, plan, steps};

/// The size of the film, in pixels.
const WIDTH: u16 = 760;
const HEIGHT: u16 = 400;

/// The upper left corner of the camera's image, and one of its pixels, in pixels.
const CAMERA: (f64, f64) = (402.0, 18.0);
const PIXEL: f64 = 17.0;

/// How long a frame stays, in hundredths of a second; the last stays longer.
const STEP_TIME: u16 = 33;
const LAST_TIME: u16 = 250;

/// An escape as a GIF of about three steps a second, without end: the room from above on the left;
/// on the right what the camera sees, and beneath it the preference for each action, as [`states`]
/// shows it. There is a frame for each step and one for the end.
///
/// [`states`]: super::states()
pub fn animation(escape: &Escape) -> Vec<u8> {
    let mut file = Vec::new();
    write(escape, &mut file).expect("frames of the announced size are written to memory");
    file
}

fn write(escape: &Escape, file: &mut Vec<u8>) -> Result<(), gif::EncodingError> {
    let mut encoder = Encoder::new(file, WIDTH, HEIGHT, &[])?;
    encoder.set_repeat(Repeat::Infinite)?;
    let last = escape.moments.len();
    let mut before = Vec::new();
    for index in 0..=last {
        let pixels = raster(&picture(escape, index));
        let palette = Palette::of(&pixels);
        let buffer = palette.indices(&pixels, &before);
        before = pixels;
        encoder.write_frame(&Frame {
            width: WIDTH,
            height: HEIGHT,
            delay: if index < last { STEP_TIME } else { LAST_TIME },
            buffer: Cow::Owned(buffer),
            palette: Some(palette.bytes()),
            transparent: Some(palette::UNCHANGED),
            ..Frame::default()
        })?;
    }
    Ok(())
}

/// The frame before the step `index`, or the last, as an SVG file without words: these would take
/// their shape from the fonts of the machine.
fn picture(escape: &Escape, index: usize) -> String {
    let moment = escape.moments.get(index);
    let (pose, scene) =
        moment.map_or((escape.last.0, &escape.last.1), |moment| (moment.pose, &moment.scene));
    let mut drawing = Drawing::new(WIDTH.into(), HEIGHT.into());
    plan::room(&mut drawing, (12.0, 12.0), 376.0, |drawing| {
        plan::scene(drawing, scene);
        steps::path(drawing, escape.steps().take(index), MUTED, false);
        plan::robot(drawing, pose, INK, 1.0);
    });

    let values = || escape.moments.iter().map(|moment| &moment.values);
    let (scale, full) = (ColourScale::of(values().flatten()), full_ring(values()));
    let (centre, radius) = ((572.0, 270.0), 101.0);
    match moment {
        Some(moment) => {
            camera(&mut drawing, &moment.image, CAMERA, PIXEL);
            let compass = Compass { centre, radius, full, scale };
            compass.draw(&mut drawing, &moment.values, moment.action);
        }
        None => end(&mut drawing, escape.escaped),
    }
    drawing.finish("Escape", "")
}

/// Draws what stands in the place of camera and compass after the last step, when nothing is seen
/// any more: a tick where the robot is out.
fn end(drawing: &mut Drawing, escaped: bool) {
    let ((x, y), (width, height)) = (CAMERA, (PIXEL * Image::WIDTH as f64, 364.0));
    let colour = if escaped { EXIT } else { GRID };
    drawing.add(format_args!(
        "<rect x='{x}' y='{y}' width='{width}' height='{height}' fill='{colour}'/>"
    ));
    if escaped {
        drawing.add(format_args!(
            "<path d='M516 204L556 244L628 160' fill='none' stroke='{PAGE}' stroke-width='22' \
             stroke-linecap='round' stroke-linejoin='round'/>"
        ));
    }
}

/// The pixels of a picture of the film's size, row by row.
fn raster(svg: &str) -> Vec<[u8; 3]> {
    let tree = usvg::Tree::from_str(svg, &usvg::Options::default())
        .expect("the pictures of this module are SVG");
    let mut canvas = Pixmap::new(WIDTH.into(), HEIGHT.into()).expect("the film has an area");
    resvg::render(&tree, Transform::identity(), &mut canvas.as_mut());
    // The ground of a picture is opaque, so nothing is left of alpha.
    canvas.pixels().iter().map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]).collect()
}
