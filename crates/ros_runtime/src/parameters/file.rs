//! Parameter files: YAML as rcl reads it.
//!
//! ```yaml
//! /**:                 # every node; /robot1/** and /*/sim_node are wildcards too
//!   ros__parameters:
//!     seed: 3
//! /robot1/sim_node:    # one node; `robot1: sim_node:` nested means the same
//!   ros__parameters:
//!     camera: {height: 0.09}   # the parameter camera.height
//! ```

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use serde::Deserialize;
use thiserror::Error;

use super::ParameterValue;

const PARAMETERS: &str = "ros__parameters";

/// Why a parameter file cannot be used.
#[derive(Debug, Error)]
pub enum ParameterFileError {
    /// The file cannot be opened.
    #[error("parameter file {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// The text is no YAML, or not of ROS's form.
    #[error("parameter file {path}: {reason}")]
    Form {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        reason: String,
    },
}

/// The parameters that one name or pattern of a file gets.
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
    let tree: BTreeMap<String, Tree> = serde_saphyr::from_str(text)
        .map_err(|error| error.to_string().lines().next().unwrap_or_default().to_owned())?;
    let mut sections = Vec::new();
    collect_sections("", tree, &mut sections)?;
    // The more special pattern wins, wherever it stands: wildcards come first.
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
                    "'{key}' is {value}: expected 'node_name:' with '{PARAMETERS}:' below it"
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

    /// Whether nodes of any name are meant, so that this node need not know every parameter.
    pub(super) fn is_for_all(&self) -> bool {
        self.pattern.ends_with('*')
    }

    /// `*` stands for one token, `**` for any number of them.
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
    fn sections_names_and_nested_parameters() {
        let text = "
/**: {ros__parameters: {seed: 3, use_sim_time: false}}
sim_node:
  ros__parameters:
    camera: {height: 0.09, pitch: 0.0}
    fixed_cylinders: [0.1, 0.2]
robot1:
  sim_node: {ros__parameters: {scenario: concave}}
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
        let root = of("/sim_node");
        assert_eq!(root["camera.height"], ParameterValue::Double(0.09));
        assert_eq!(root["fixed_cylinders"], ParameterValue::DoubleArray(vec![0.1, 0.2]));
        assert_eq!(root["seed"], ParameterValue::Integer(3));
        let moved = of("/robot1/sim_node");
        assert_eq!(moved["scenario"], ParameterValue::String("concave".into()));
        assert!(!moved.contains_key("camera.height"));
        assert_eq!(of("/agent_node").len(), 2);
    }

    proptest! {
        /// Any text gives sections with absolute patterns, or a reason in one line.
        #[test]
        fn any_text_is_read_or_refused_in_one_line(text in "([a-z/*_]{0,6}: ?|[-\\[\\]{}&*!|>'\"%@,#]| {1,4}|\\n|[0-9.e]{1,5}){0,40}") {
            match parse(&text) {
                Ok(sections) => {
                    prop_assert!(sections.iter().all(|section| section.pattern.starts_with('/')));
                }
                Err(reason) => prop_assert_eq!(reason.lines().count(), 1, "{}", reason),
            }
        }
    }

    #[test]
    fn patterns() {
        let matches = |pattern: &str, name: &str| {
            Section { pattern: pattern.into(), parameters: BTreeMap::new() }.matches(name)
        };
        assert!(matches("/**", "/a/b") && matches("/a/**", "/a/b/c") && matches("/*/b", "/a/b"));
        assert!(!matches("/*/b", "/b") && !matches("/*", "/a/b") && matches("/**/b", "/b"));
    }

    #[test]
    fn what_is_no_parameter_file_is_refused() {
        for text in ["seed: 3", "a: [", "- 1", "sim_node:\n  ros__parameters: 3"] {
            assert!(parse(text).is_err(), "{text}");
        }
    }
}
