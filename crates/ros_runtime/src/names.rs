//! Names of nodes, topics and services, and their remapping.
//!
//! The rules are those of <https://design.ros2.org/articles/topic_and_service_names.html>: a name
//! that begins with `/` is absolute, a name that begins with `~/` is private to its node, and any
//! other name is relative to the node's namespace.

use std::str::FromStr;

use thiserror::Error;

use crate::escape::escaped;

/// A remapping rule, as given with `-r`: `[node:]from:=to`.
///
/// # Examples
///
/// ```
/// use ros_runtime::names::Remap;
///
/// let remap: Remap = "camera:image:=/front".parse()?;
/// assert_eq!(remap.node.as_deref(), Some("camera"));
/// assert_eq!((remap.from.as_str(), remap.to.as_str()), ("image", "/front"));
/// assert!("image".parse::<Remap>().is_err());
/// # Ok::<(), ros_runtime::names::RemapError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Remap {
    /// The name of the node to which the rule applies; `None` for every node.
    pub node: Option<String>,
    /// The name to replace, or `__node`, `__name` or `__ns`.
    pub from: String,
    /// The replacement.
    pub to: String,
}

/// The error returned for an invalid remapping rule.
#[derive(Debug, Error, PartialEq)]
#[error(
    "couldn't parse the remapping '{}': expected 'from:=to', 'node:from:=to', '__node:=name' or \
     '__ns:=/namespace'",
    escaped(.0)
)]
pub struct RemapError(String);

impl FromStr for Remap {
    type Err = RemapError;

    fn from_str(rule: &str) -> Result<Remap, RemapError> {
        let error = || RemapError(rule.to_owned());
        let (from, to) = rule.split_once(":=").ok_or_else(error)?;
        let (node, from) = match from.split_once(':') {
            Some((node, from)) => (Some(node.to_owned()), from),
            None => (None, from),
        };
        if from.is_empty() || to.is_empty() || node.as_ref().is_some_and(String::is_empty) {
            return Err(error());
        }
        let is_name = match from {
            "__node" | "__name" => is_token(to),
            "__ns" => is_namespace(to),
            _ => is_name(from) && is_name(to),
        };
        if is_name {
            Ok(Remap { node, from: from.to_owned(), to: to.to_owned() })
        } else {
            Err(error())
        }
    }
}

/// The error returned for an invalid name.
#[derive(Debug, Error, PartialEq)]
#[error(
    "'{}' is not a valid name: expected tokens of letters, digits and single underscores that do \
     not begin with a digit, between single slashes, such as 'camera/image', '/scan' or '~/state'",
    escaped(.0)
)]
pub struct InvalidName(String);

/// A node's name and namespace, and the remapping rules that apply to it.
///
/// # Examples
///
/// ```
/// use ros_runtime::names::{Naming, Remap};
///
/// let remaps: [Remap; 2] = ["__ns:=/robot1".parse()?, "image:=/front".parse()?];
/// let naming = Naming::new("camera", &remaps)?;
/// assert_eq!(naming.fully_qualified(), "/robot1/camera");
/// assert_eq!(naming.resolve("~/state")?, "/robot1/camera/state");
/// assert_eq!(naming.resolve("image")?, "/front");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Naming {
    /// The node's name, without a namespace.
    pub node: String,
    /// The node's namespace: `/` or `/one/two`.
    pub namespace: String,
    rules: Vec<(String, String)>,
}

impl Naming {
    /// Applies remapping rules to a node. `default_name` is the node's name if no rule remaps
    /// `__node`, and the name by which rules refer to the node.
    ///
    /// # Errors
    ///
    /// Returns an error if a rule contains an invalid name.
    pub fn new(default_name: &str, remaps: &[Remap]) -> Result<Naming, InvalidName> {
        let applies =
            |remap: &&Remap| remap.node.as_deref().is_none_or(|node| node == default_name);
        let special = |names: &[&str]| {
            let mut matching = remaps.iter().filter(applies);
            matching
                .find(|remap| names.contains(&remap.from.as_str()))
                .map(|remap| remap.to.clone())
        };
        let mut naming = Naming {
            node: special(&["__node", "__name"]).unwrap_or_else(|| default_name.to_owned()),
            namespace: special(&["__ns"]).unwrap_or_else(|| "/".to_owned()),
            rules: Vec::new(),
        };
        for remap in remaps.iter().filter(applies).filter(|remap| !remap.from.starts_with("__")) {
            let rule = (naming.expand(&remap.from)?, naming.expand(&remap.to)?);
            naming.rules.push(rule);
        }
        Ok(naming)
    }

    /// Returns the node's name with its namespace, such as `/robot1/camera`.
    pub fn fully_qualified(&self) -> String {
        join(&self.namespace, &self.node)
    }

    /// Expands and remaps the name of a topic or service. The result is absolute.
    ///
    /// # Errors
    ///
    /// Returns an error if the name is invalid.
    pub fn resolve(&self, name: &str) -> Result<String, InvalidName> {
        let expanded = self.expand(name)?;
        let rule = self.rules.iter().find(|(from, _)| *from == expanded);
        Ok(rule.map_or(expanded, |(_, to)| to.clone()))
    }

    fn expand(&self, name: &str) -> Result<String, InvalidName> {
        if !is_name(name) {
            return Err(InvalidName(name.to_owned()));
        }
        Ok(if name.starts_with('/') {
            name.to_owned()
        } else if let Some(private) = name.strip_prefix("~/") {
            join(&self.fully_qualified(), private)
        } else {
            join(&self.namespace, name)
        })
    }
}

fn join(namespace: &str, name: &str) -> String {
    format!("{}/{name}", namespace.trim_end_matches('/'))
}

/// Returns whether a text is `/` or an absolute name.
pub(crate) fn is_namespace(text: &str) -> bool {
    text == "/" || (text.starts_with('/') && is_name(text))
}

fn is_name(name: &str) -> bool {
    let relative = name.strip_prefix("~/").or(name.strip_prefix('/')).unwrap_or(name);
    relative.split('/').all(is_token)
}

fn is_token(token: &str) -> bool {
    token.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_')
        && token.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !token.contains("__")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn naming(rules: &[&str]) -> Naming {
        let remaps: Vec<Remap> = rules.iter().map(|rule| rule.parse().unwrap()).collect();
        Naming::new("camera", &remaps).unwrap()
    }

    #[test]
    fn resolves_relative_private_and_absolute_names() {
        let root = naming(&[]);
        assert_eq!(root.resolve("stereo/image").unwrap(), "/stereo/image");
        assert_eq!(root.resolve("~/state").unwrap(), "/camera/state");
        let moved = naming(&["__ns:=/robot1", "__node:=front"]);
        assert_eq!(moved.fully_qualified(), "/robot1/front");
        assert_eq!(moved.resolve("stereo/image").unwrap(), "/robot1/stereo/image");
        assert_eq!(moved.resolve("~/state").unwrap(), "/robot1/front/state");
        assert_eq!(moved.resolve("/rosout").unwrap(), "/rosout");
    }

    #[test]
    fn rules_apply_to_the_expanded_name() {
        let remapped = naming(&["__ns:=/a", "stereo/image:=/front", "other:reset:=start"]);
        assert_eq!(remapped.resolve("stereo/image").unwrap(), "/front");
        assert_eq!(remapped.resolve("/a/stereo/image").unwrap(), "/front");
        assert_eq!(remapped.resolve("reset").unwrap(), "/a/reset", "the rule is for another node");
        assert_eq!(naming(&["camera:reset:=start"]).resolve("reset").unwrap(), "/start");
    }

    #[test]
    fn rejects_invalid_names_and_rules() {
        for rule in ["abc", ":=x", "a:=", "a b:=c", "__ns:=relative", "__node:=a/b", "a//b:=c"] {
            assert!(rule.parse::<Remap>().is_err(), "{rule}");
        }
        for name in ["", "/", "a/", "1a", "a__b", "a-b", "~"] {
            assert!(naming(&[]).resolve(name).is_err(), "{name}");
        }
    }

    #[test]
    fn errors_escape_the_text_that_they_quote() {
        let error = naming(&[]).resolve("a\nb").unwrap_err().to_string();
        let expected = "'a\\nb' is not a valid name: expected tokens of letters, digits and single \
                        underscores that do not begin with a digit, between single slashes, such \
                        as 'camera/image', '/scan' or '~/state'";
        assert_eq!(error, expected);
    }
}
