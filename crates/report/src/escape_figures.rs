//! The figures of a policy's escapes, as files and embedded in the page.

use base64::{Engine, prelude::BASE64_STANDARD};

use super::escape::{Escape, animation, paths, rooms, sample_states, states, trails};

/// The figures of a policy's escapes in one scenario, modelled on Figures 4 to 7 of the paper.
#[derive(Clone, Debug, PartialEq)]
pub struct EscapeFigures {
    figures: Vec<EscapeFigure>,
    /// GIF file; empty if there is no escape.
    animation: Vec<u8>,
}

/// A figure that shows one or more escapes.
#[derive(Clone, Debug, PartialEq)]
pub struct EscapeFigure {
    /// File name without extension.
    pub name: &'static str,
    /// Title on the page.
    pub title: &'static str,
    /// Caption on the page.
    pub caption: &'static str,
    /// SVG file.
    pub svg: String,
}

impl EscapeFigures {
    /// Draws the figures. `random` holds escapes from random rooms; `fixed` holds escapes that
    /// start in the same layout of exit and obstacles, or is empty. `moving` states whether the
    /// obstacles move.
    pub fn draw(random: &[Escape], fixed: &[Escape], moving: bool) -> EscapeFigures {
        let mut figures = Vec::new();
        if let Some(first) = fixed.first() {
            if moving {
                figures.push(EscapeFigure {
                    name: "trails",
                    title: "Escape among moving obstacles",
                    caption: "Arrows are the robot's steps; trails are the paths of the obstacles. \
                              Fainter means earlier. The paper shows moving obstacles only in its \
                              videos.",
                    svg: trails(first),
                });
            } else {
                figures.push(EscapeFigure {
                    name: "paths",
                    title: "Escapes from the same room",
                    caption: "The exit and the obstacles are fixed; the start pose varies. Arrows \
                              are steps; crosses are blocked moves. Compare with Figures 4, 5 and \
                              7 of the paper.",
                    svg: paths(fixed),
                });
            }
            figures.push(EscapeFigure {
                name: "states",
                title: "Camera images and action preferences",
                caption: "The camera images at three poses of the first escape and, below each, \
                          the preference for each action: the softmax of the Q-values.",
                svg: states(first, sample_states(first)),
            });
        }
        figures.push(EscapeFigure {
            name: "rooms",
            title: "Escapes from random rooms",
            caption: "The first rooms of the evaluation. Compare with Figure 6 of the paper.",
            svg: rooms(random),
        });
        let shown = fixed.first().or(random.first());
        EscapeFigures { figures, animation: shown.map_or_else(Vec::new, animation) }
    }

    /// Returns the figures in the order in which the page shows them.
    pub fn figures(&self) -> &[EscapeFigure] {
        &self.figures
    }

    /// Returns the name and the content of each file: the figures and the animation, if any.
    pub fn files(&self) -> impl Iterator<Item = (String, &[u8])> {
        let figures = self.figures.iter();
        let svgs = figures.map(|figure| (format!("{}.svg", figure.name), figure.svg.as_bytes()));
        let animation = (!self.animation.is_empty())
            .then(|| ("escape.gif".to_owned(), self.animation.as_slice()));
        svgs.chain(animation)
    }

    /// Returns the animation as a `data:` URI, or `None` if there is none.
    pub(super) fn animation_uri(&self) -> Option<String> {
        let data = BASE64_STANDARD.encode(&self.animation);
        (!self.animation.is_empty()).then(|| format!("data:image/gif;base64,{data}"))
    }
}
