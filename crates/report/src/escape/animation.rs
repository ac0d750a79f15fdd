//! The animation of an escape.

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
use super::preference::{PolarPlot, full_ring};
use super::{Escape, plan, steps};

/// Size of the animation in pixels.
const WIDTH: u16 = 760;
const HEIGHT: u16 = 400;

/// Upper left corner of the camera image in pixels.
const CAMERA: (f64, f64) = (402.0, 18.0);
/// Size of a pixel of the camera image in pixels of the animation.
const PIXEL: f64 = 17.0;

/// Duration of a step's frame, in hundredths of a second.
const STEP_TIME: u16 = 33;
/// Duration of the last frame, in hundredths of a second.
const LAST_TIME: u16 = 250;

/// Maximum number of steps shown. A frame takes a sixth of a second to draw, and a failed episode
/// can have hundreds of steps.
const MAX_STEPS: usize = 60;

/// Returns an escape as a GIF that shows three steps per second and loops forever.
///
/// The left half shows the room from above, the right half the camera image and, below it, the
/// preference for each action as in [`states`]. The GIF has one frame for each of the
/// first 60 steps and a final frame.
///
/// [`states`]: super::states()
pub fn animation(escape: &Escape) -> Vec<u8> {
    let mut file = Vec::new();
    write(escape, &mut file)
        .expect("frames have the declared size, and writing to memory cannot fail");
    file
}

fn write(escape: &Escape, file: &mut Vec<u8>) -> Result<(), gif::EncodingError> {
    let mut encoder = Encoder::new(file, WIDTH, HEIGHT, &[])?;
    encoder.set_repeat(Repeat::Infinite)?;
    let last = escape.moments.len();
    let mut previous = Vec::new();
    for index in (0..last.min(MAX_STEPS)).chain([last]) {
        let pixels = rasterize(&frame(escape, index));
        let palette = Palette::of(&pixels);
        let buffer = palette.indices(&pixels, &previous);
        previous = pixels;
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

/// Returns the frame of step `index`, or the final frame, as an SVG file. The frame shows no
/// text, because its appearance would depend on the fonts installed on the machine.
fn frame(escape: &Escape, index: usize) -> String {
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
            let plot = PolarPlot { centre, radius, full, scale };
            plot.draw(&mut drawing, &moment.values, moment.action);
        }
        None => result(&mut drawing, escape.escaped),
    }
    drawing.finish("Escape", "")
}

/// Draws the result of the episode in place of the camera image and the preferences: a check mark
/// if the robot reached the exit, otherwise an empty grey area.
fn result(drawing: &mut Drawing, escaped: bool) {
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

/// Rasterizes an SVG file that has the size of the animation. Returns its pixels row by row, each
/// as red, green and blue.
fn rasterize(svg: &str) -> Vec<[u8; 3]> {
    let tree = usvg::Tree::from_str(svg, &usvg::Options::default())
        .expect("the frames of this module are valid SVG");
    let mut canvas = Pixmap::new(WIDTH.into(), HEIGHT.into()).expect("the size is not zero");
    resvg::render(&tree, Transform::identity(), &mut canvas.as_mut());
    // The background is opaque, so alpha can be dropped.
    canvas.pixels().iter().map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]).collect()
}
