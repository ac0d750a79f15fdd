//! An SVG picture, written element by element.

use std::fmt::{Arguments, Write};

use super::colours;

/// A picture in the making. Its unit is the pixel of a page; y points down.
pub(super) struct Drawing {
    width: u32,
    height: u32,
    body: String,
}

impl Drawing {
    /// An empty page of so many pixels.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, body: String::new() }
    }

    /// Adds an element, or several, above everything so far.
    pub fn add(&mut self, element: Arguments) {
        self.body.write_fmt(element).expect("a string takes what is written");
        self.body.push('\n');
    }

    /// Adds what `draw` draws as a group with these attributes.
    pub fn group(&mut self, attributes: Arguments, draw: impl FnOnce(&mut Self)) {
        self.add(format_args!("<g {attributes}>"));
        draw(self);
        self.add(format_args!("</g>"));
    }

    /// Adds words that begin at a point, on its line, unless the attributes say otherwise. They are
    /// words of this module, which need no escapes.
    pub fn text(&mut self, (x, y): (f64, f64), attributes: &str, words: impl AsRef<str>) {
        let words = words.as_ref();
        self.add(format_args!("<text x='{x:.1}' y='{y:.1}' {attributes}>{words}</text>"));
    }

    /// The picture as a file, with what it is called and what it shows for those who cannot see it.
    pub fn finish(self, title: &str, description: &str) -> String {
        let Self { width, height, body } = self;
        format!(
            "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width} {height}' \
             width='{width}' height='{height}' role='img' font-size='15' fill='{ink}' \
             font-family='system-ui, -apple-system, \"Segoe UI\", Roboto, \"Helvetica Neue\", \
             Arial, sans-serif'>\n\
             <title>{title}</title>\n<desc>{description}</desc>\n\
             <rect width='{width}' height='{height}' fill='{page}'/>\n{body}</svg>\n",
            ink = colours::INK,
            page = colours::PAGE,
        )
    }
}
