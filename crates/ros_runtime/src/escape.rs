//! Escapes external text that is quoted in one-line messages.

use std::{fmt, path::Path};

/// Returns a value that [displays](fmt::Display) a text on one line.
///
/// Line breaks, other control characters, invisible characters and backslashes are escaped as in
/// [`str::escape_debug`]. Quotes and printable characters of any script are left unchanged.
pub(crate) fn escaped(text: &str) -> Escaped<'_> {
    Escaped(text)
}

/// Returns a path as [`escaped`] text; bytes that are not UTF-8 become U+FFFD.
pub(crate) fn escaped_path(path: &Path) -> String {
    escaped(&path.to_string_lossy()).to_string()
}

/// See [`escaped`].
pub(crate) struct Escaped<'text>(&'text str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const QUOTES: [char; 2] = ['\'', '"'];
        // `str::escape_debug` would also escape quotes, so they are written separately.
        for part in self.0.split_inclusive(QUOTES) {
            let text = part.trim_end_matches(QUOTES);
            write!(f, "{}{}", text.escape_debug(), &part[text.len()..])?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn escapes_characters_that_would_break_or_hide_a_line() {
        for (text, expected) in [
            ("0\ne", r"0\ne"),
            ("a\r\n\tb\0", r"a\r\n\tb\0"),
            ("\u{1b}[31mred", r"\u{1b}[31mred"),
            ("next\u{85}line\u{2028}paragraph\u{2029}", r"next\u{85}line\u{2028}paragraph\u{2029}"),
            ("zero\u{200b}width", r"zero\u{200b}width"),
            (r"C:\new", r"C:\\new"),
        ] {
            assert_eq!(escaped(text).to_string(), expected);
        }
    }

    proptest! {
        #[test]
        fn any_text_stays_on_one_line(text in "(?s).{0,40}") {
            let line = escaped(&text).to_string();
            let breaks = |c: char| c.is_control() || c == '\u{2028}' || c == '\u{2029}';
            prop_assert!(!line.contains(breaks), "{:?}", line);
        }
    }

    #[test]
    fn leaves_quotes_and_printable_text_unchanged() {
        for text in
            ["", "runs/one", "it's {\"a\": 'b'}", "'\"", "größe", "部屋", "नमस्ते", "e\u{301}"]
        {
            assert_eq!(escaped(text).to_string(), text);
        }
    }

    #[test]
    fn escapes_paths() {
        assert_eq!(escaped_path(Path::new("/tmp/a\nb.yaml")), r"/tmp/a\nb.yaml");
    }
}
