//! Names of nodes, topics and services: relative, private and absolute, and their remapping.
//!
//! The rules are those of <https://design.ros2.org/articles/topic_and_service_names.html>: a name
//! that begins with `/` is absolute, one that begins with `~/` is private to its node, any other is
//! relative to the node's namespace.

use std::str::FromStr;

use thiserror::Error;

/// One `-r` rule: `[node:]from:=to`.
#[derive(Clone, Debug, PartialEq)]
pub struct Remap {
    /// The node that the rule is for; every node if there is none.
    pub node: Option<String>,
    /// The name to replace, or `__node`, `__name` or `__ns`.
    pub from: String,
    /// Its replacement.
    pub to: String,
}

/// Why a text is not a remapping.
#[derive(Debug, Error, PartialEq)]
#[error(
    "couldn't parse the remapping '{0}': expected 'from:=to', 'node:from:=to', '__node:=name' or \
     '__ns:=/namespace'"
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

/// Why a name cannot be used.
#[derive(Debug, Error, PartialEq)]
#[error(
    "'{0}' is no valid name: expected tokens of letters, digits and single underscores that do not \
     begin with a digit, between single slashes, such as 'camera/image', '/scan' or '~/state'"
)]
pub struct InvalidName(String);

/// Where a node stands, and which names were remapped for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Naming {
    /// The node's name, without a namespace.
    pub node: String,
    /// The node's namespace: `/` or `/one/two`.
    pub namespace: String,
    rules: Vec<(String, String)>,
}

impl Naming {
    /// The naming of the node that its program calls `default_name`.
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

    /// The node's name with its namespace, such as `/robot1/sim_node`.
    pub fn fully_qualified(&self) -> String {
        join(&self.namespace, &self.node)
    }

    /// The absolute name that a topic or service has after expansion and remapping.
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

/// Whether a text is `/` or an absolute name.
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
        Naming::new("sim_node", &remaps).unwrap()
    }

    #[test]
    fn relative_private_and_absolute_names() {
        let root = naming(&[]);
        assert_eq!(root.resolve("camera/image").unwrap(), "/camera/image");
        assert_eq!(root.resolve("~/state").unwrap(), "/sim_node/state");
        let moved = naming(&["__ns:=/robot1", "__node:=room"]);
        assert_eq!(moved.fully_qualified(), "/robot1/room");
        assert_eq!(moved.resolve("camera/image").unwrap(), "/robot1/camera/image");
        assert_eq!(moved.resolve("~/state").unwrap(), "/robot1/room/state");
        assert_eq!(moved.resolve("/rosout").unwrap(), "/rosout");
    }

    #[test]
    fn rules_apply_to_the_expanded_name() {
        let remapped = naming(&["__ns:=/a", "camera/image:=/front", "other:reset:=start"]);
        assert_eq!(remapped.resolve("camera/image").unwrap(), "/front");
        assert_eq!(remapped.resolve("/a/camera/image").unwrap(), "/front");
        assert_eq!(remapped.resolve("reset").unwrap(), "/a/reset", "a rule of another node");
        assert_eq!(naming(&["sim_node:reset:=start"]).resolve("reset").unwrap(), "/start");
    }

    #[test]
    fn what_is_no_name_is_refused() {
        for rule in ["abc", ":=x", "a:=", "a b:=c", "__ns:=relative", "__node:=a/b", "a//b:=c"] {
            assert!(rule.parse::<Remap>().is_err(), "{rule}");
        }
        for name in ["", "/", "a/", "1a", "a__b", "a-b", "~"] {
            assert!(naming(&[]).resolve(name).is_err(), "{name}");
        }
    }
}
