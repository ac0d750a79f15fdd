//! An SVG file, written element by element.

use std::fmt::{Arguments, Write};

use super::colours;

/// An SVG file under construction. Coordinates are in pixels; y points down.
pub(crate) struct Drawing {
    width: u32,
    height: u32,
    body: String,
}

impl Drawing {
    /// Returns an empty drawing of `width` x `height` pixels.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, body: String::new() }
    }

    /// Adds one or more elements on top of the existing ones.
    pub fn add(&mut self, element: Arguments) {
        self.body.write_fmt(element).expect("writing to a string cannot fail");
        self.body.push('\n');
    }

    /// Adds the elements that `draw` adds, as a group with the given attributes.
    pub fn group(&mut self, attributes: Arguments, draw: impl FnOnce(&mut Self)) {
        self.add(format_args!("<g {attributes}>"));
        draw(self);
        self.add(format_args!("</g>"));
    }

    /// Adds text that starts at (x, y), a point on its baseline, unless `attributes` sets another
    /// anchor. The text is not escaped: it must not contain markup characters.
    pub fn text(&mut self, (x, y): (f64, f64), attributes: &str, text: impl AsRef<str>) {
        let text = text.as_ref();
        self.add(format_args!("<text x='{x:.1}' y='{y:.1}' {attributes}>{text}</text>"));
    }

    /// Returns the SVG file, with a title and a description for screen readers.
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
