//! Parameter files, in rcl's YAML format.
//!
//! ```yaml
//! /**:               # every node; other wildcards: /robot1/**, /*/camera
//!   ros__parameters:
//!     use_sim_time: true
//! /robot1/camera:    # one node; the nested form `robot1: {camera: ...}` is equivalent
//!   ros__parameters:
//!     lens: {width: 0.09}   # the parameter lens.width
//! ```

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use serde::Deserialize;
use thiserror::Error;

use super::ParameterValue;
use crate::escape::{escaped, escaped_path};

const PARAMETERS: &str = "ros__parameters";

/// The error returned for an unusable parameter file.
#[derive(Debug, Error)]
pub enum ParameterFileError {
    /// The file cannot be read.
    #[error("parameter file {}: {source}", escaped_path(.path))]
    Read {
        /// The file.
        path: PathBuf,
        /// The operating system's error.
        source: std::io::Error,
    },
    /// The text is not valid YAML or not a parameter file.
    #[error("parameter file {}: {reason}", escaped_path(.path))]
    Form {
        /// The file.
        path: PathBuf,
        /// The problem and its location, on one line.
        reason: String,
    },
}

/// The parameters in a file for the nodes that match one name or pattern.
#[derive(Debug, PartialEq)]
pub(super) struct Section {
    pattern: String,
    pub(super) parameters: BTreeMap<String, ParameterValue>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Tree {
    Value(ParameterValue),
    Branch(BTreeMap<String, Tree>),
}

pub(super) fn read(path: &Path) -> Result<Vec<Section>, ParameterFileError> {
    let text = std::fs::read_to_string(path)
        .map_err(|source| ParameterFileError::Read { path: path.to_owned(), source })?;
    parse(&text).map_err(|reason| ParameterFileError::Form { path: path.to_owned(), reason })
}

fn parse(text: &str) -> Result<Vec<Section>, String> {
    let tree: BTreeMap<String, Tree> = serde_saphyr::from_str(text).map_err(|error| {
        // The remaining lines of the message show an excerpt of the file.
        let message = error.to_string();
        escaped(message.lines().next().unwrap_or_default()).to_string()
    })?;
    let mut sections = Vec::new();
    collect_sections("", tree, &mut sections)?;
    // Later sections override earlier ones, so wildcards come first, wherever they are in the file.
    sections.sort_by_key(|section| !section.is_wildcard());
    Ok(sections)
}

fn collect_sections(
    prefix: &str,
    tree: BTreeMap<String, Tree>,
    sections: &mut Vec<Section>,
) -> Result<(), String> {
    for (key, subtree) in tree {
        match subtree {
            Tree::Branch(branch) if key == PARAMETERS => {
                let mut parameters = BTreeMap::new();
                flatten("", branch, &mut parameters);
                sections.push(Section { pattern: prefix.to_owned(), parameters });
            }
            Tree::Branch(branch) => {
                let name = format!("{prefix}/{}", key.trim_start_matches('/'));
                collect_sections(&name, branch, sections)?;
            }
            Tree::Value(value) => {
                return Err(format!(
                    "'{}' is {value}: expected 'node_name:' with '{PARAMETERS}:' below it",
                    escaped(&key)
                ));
            }
        }
    }
    Ok(())
}

fn flatten(
    prefix: &str,
    tree: BTreeMap<String, Tree>,
    parameters: &mut BTreeMap<String, ParameterValue>,
) {
    for (key, subtree) in tree {
        let name = if prefix.is_empty() { key } else { format!("{prefix}.{key}") };
        match subtree {
            Tree::Value(value) => {
                parameters.insert(name, value);
            }
            Tree::Branch(branch) => flatten(&name, branch, parameters),
        }
    }
}

impl Section {
    pub(super) fn is_wildcard(&self) -> bool {
        self.pattern.contains('*')
    }

    /// Returns whether the pattern ends with a wildcard. A node may lack some of the parameters in
    /// such a section.
    pub(super) fn is_for_all(&self) -> bool {
        self.pattern.ends_with('*')
    }

    /// Returns whether the pattern matches a node: `*` matches one token, `**` any number of
    /// tokens.
    pub(super) fn matches(&self, fully_qualified_name: &str) -> bool {
        let pattern: Vec<&str> = self.pattern.split('/').skip(1).collect();
        let name: Vec<&str> = fully_qualified_name.split('/').skip(1).collect();
        tokens_match(&pattern, &name)
    }
}

fn tokens_match(pattern: &[&str], name: &[&str]) -> bool {
    match (pattern, name) {
        ([], []) => true,
        (["**", rest @ ..], _) => (0..=name.len()).any(|skip| tokens_match(rest, &name[skip..])),
        (["*", pattern @ ..], [_, name @ ..]) => tokens_match(pattern, name),
        ([token, pattern @ ..], [first, name @ ..]) => {
            token == first && tokens_match(pattern, name)
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn reads_wildcards_nested_nodes_and_nested_parameters() {
        let text = "
/**: {ros__parameters: {seed: 3, use_sim_time: false}}
camera:
  ros__parameters:
    lens: {width: 0.09, pitch: 0.0}
    offsets: [0.1, 0.2]
robot1:
  camera: {ros__parameters: {mode: gray}}
";
        let sections = parse(text).unwrap();
        let of = |name: &str| {
            let mut parameters = BTreeMap::new();
            for section in parse(text).unwrap() {
                if section.matches(name) {
                    parameters.extend(section.parameters);
                }
            }
            parameters
        };
        assert_eq!(sections.len(), 3);
        let root = of("/camera");
        assert_eq!(root["lens.width"], ParameterValue::Double(0.09));
        assert_eq!(root["offsets"], ParameterValue::DoubleArray(vec![0.1, 0.2]));
        assert_eq!(root["seed"], ParameterValue::Integer(3));
        let moved = of("/robot1/camera");
        assert_eq!(moved["mode"], ParameterValue::String("gray".into()));
        assert!(!moved.contains_key("lens.width"));
        assert_eq!(of("/planner").len(), 2);
    }

    proptest! {
        /// Any text yields sections with absolute patterns or a one-line error.
        #[test]
        fn any_text_is_parsed_or_rejected_with_a_one_line_error(
            text in "([a-z/*_]{0,6}: ?|[-\\[\\]{}&*!|>'\"%@,#]| {1,4}|\\n|[0-9.e]{1,5}){0,40}"
        ) {
            match parse(&text) {
                Ok(sections) => {
                    prop_assert!(sections.iter().all(|section| section.pattern.starts_with('/')));
                }
                Err(reason) => prop_assert_eq!(reason.lines().count(), 1, "{}", reason),
            }
        }
    }

    #[test]
    fn matches_nodes_by_patterns() {
        let matches = |pattern: &str, name: &str| {
            Section { pattern: pattern.into(), parameters: BTreeMap::new() }.matches(name)
        };
        assert!(matches("/**", "/a/b") && matches("/a/**", "/a/b/c") && matches("/*/b", "/a/b"));
        assert!(!matches("/*/b", "/b") && !matches("/*", "/a/b") && matches("/**/b", "/b"));
    }

    #[test]
    fn rejects_text_that_is_not_a_parameter_file() {
        for text in ["seed: 3", "a: [", "- 1", "camera:\n  ros__parameters: 3"] {
            assert!(parse(text).is_err(), "{text}");
        }
    }

    /// The texts contain a plain scalar with several lines, and keys and values with escaped line
    /// breaks.
    #[test]
    fn errors_escape_the_keys_and_values_that_they_quote() {
        for (text, key, value) in [
            ("_: 0\n\n e", "_", r"the string '0\ne'"),
            (r#""a\nb": 3"#, r"a\nb", "the integer 3"),
            (r#"größe: "1\r\n2""#, "größe", r"the string '1\r\n2'"),
            (r#"list: ["a\nb"]"#, "list", r#"the list ["a\nb"]"#),
        ] {
            let expected = format!(
                "'{key}' is {value}: expected 'node_name:' with 'ros__parameters:' below it"
            );
            assert_eq!(parse(text), Err(expected));
        }
    }

    #[test]
    fn errors_escape_the_path() {
        let path = Path::new("/nowhere\n/parameters.yaml");
        let error = read(path).unwrap_err().to_string();
        let expected = r"parameter file /nowhere\n/parameters.yaml: No such file or directory";
        assert!(error.starts_with(expected), "{error}");
        let form = ParameterFileError::Form { path: path.to_owned(), reason: "empty".to_owned() };
        assert_eq!(form.to_string(), r"parameter file /nowhere\n/parameters.yaml: empty");
    }
}
