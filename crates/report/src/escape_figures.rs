//! The pictures of a policy's escapes, as files and on the report's page.

use base64::{Engine, prelude::BASE64_STANDARD};

use super::escape::{Escape, animation, paths, pick_states, rooms, states, trails};

/// The figures of the paper for one policy in one scenario.
#[derive(Clone, Debug, PartialEq)]
pub struct EscapeFigures {
    figures: Vec<EscapeFigure>,
    /// A GIF.
    animation: Vec<u8>,
}

/// One of them.
#[derive(Clone, Debug, PartialEq)]
pub struct EscapeFigure {
    /// Of the file, without its ending.
    pub name: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// What to know about it.
    pub caption: &'static str,
    /// The picture.
    pub svg: String,
}

impl EscapeFigures {
    /// Draws escapes from random rooms, and from one that was held fixed, whose obstacles move or not.
    pub fn draw(random: &[Escape], fixed: &[Escape], moving: bool) -> EscapeFigures {
        let mut figures = Vec::new();
        if let Some(first) = fixed.first() {
            if moving {
                figures.push(EscapeFigure {
                    name: "trails",
                    title: "A way out among moving obstacles",
                    caption: "The robot's steps, and where the obstacles went meanwhile: pale is \
                              early. The paper shows this only in its videos.",
                    svg: trails(first),
                });
            } else {
                figures.push(EscapeFigure {
                    name: "paths",
                    title: "Three ways out of one room",
                    caption: "The exit and the obstacles are held fixed; an arrow is a step, a cross \
                              a blocked one. Figures 4, 5 and 7 of the paper.",
                    svg: paths(fixed),
                });
            }
            figures.push(EscapeFigure {
                name: "states",
                title: "What it saw, and what it preferred",
                caption: "The camera's image at three places of the first way, and beside it the \
                          softmax of the seven actions' Q-values.",
                svg: states(first, pick_states(first)),
            });
        }
        figures.push(EscapeFigure {
            name: "rooms",
            title: "Ways out of other rooms",
            caption: "The first rooms of the test. Figure 6 of the paper.",
            svg: rooms(random),
        });
        let shown = fixed.first().or(random.first());
        EscapeFigures { figures, animation: shown.map_or_else(Vec::new, animation) }
    }

    /// All figures, in their order.
    pub fn figures(&self) -> &[EscapeFigure] {
        &self.figures
    }

    /// The files to keep: their names and what is in them.
    pub fn files(&self) -> impl Iterator<Item = (String, &[u8])> {
        let figures = self.figures.iter();
        let svgs = figures.map(|figure| (format!("{}.svg", figure.name), figure.svg.as_bytes()));
        let animation = (!self.animation.is_empty())
            .then(|| ("escape.gif".to_owned(), self.animation.as_slice()));
        svgs.chain(animation)
    }

    /// The animation in a `data:` URI, if there is one.
    pub(super) fn animation_uri(&self) -> Option<String> {
        let data = BASE64_STANDARD.encode(&self.animation);
        (!self.animation.is_empty()).then(|| format!("data:image/gif;base64,{data}"))
    }
}
