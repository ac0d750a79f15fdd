//! Generated sections in Markdown pages.

use std::path::Path;

use anyhow::{Context, ensure};

/// Replaces the text between the comments `<!-- NAME: begin -->` and `<!-- NAME: end -->`.
///
/// # Errors
///
/// Returns an error if the file cannot be read or written, lacks one of the comments, or has them
/// in the wrong order.
pub fn replace_section(path: &Path, name: &str, text: &str) -> anyhow::Result<()> {
    let context = || path.display().to_string();
    let page = std::fs::read_to_string(path).with_context(context)?;
    let comments = ["begin", "end"].map(|end| format!("<!-- {name}: {end} -->"));
    let [begin, end] = comments.each_ref().map(|comment| page.find(comment.as_str()));
    let range = begin.map(|begin| begin + comments[0].len()).zip(end);
    let (begin, end) = range.with_context(|| {
        format!("{}: {} or {} not found", path.display(), comments[0], comments[1])
    })?;
    ensure!(begin <= end, "{}: {} is before {}", path.display(), comments[1], comments[0]);
    let page = format!("{}\n{}\n{}", &page[..begin], text.trim_end(), &page[end..]);
    std::fs::write(path, page).with_context(context)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replaces_only_the_text_between_the_comments() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("page.md");
        std::fs::write(&path, "a\n<!-- x: begin -->\nold\n<!-- x: end -->\nb\n").unwrap();
        for text in ["new\n", "newer"] {
            replace_section(&path, "x", text).unwrap();
            let page = std::fs::read_to_string(&path).unwrap();
            let text = text.trim_end();
            assert_eq!(page, format!("a\n<!-- x: begin -->\n{text}\n<!-- x: end -->\nb\n"));
        }
        let error = replace_section(&path, "y", "").unwrap_err().to_string();
        assert!(error.contains("<!-- y: begin --> or <!-- y: end --> not found"), "{error}");
    }
}
