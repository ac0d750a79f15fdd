//! Type descriptions and type hashes (REP-2011, REP-2016).
//!
//! The hash of a type distinguishes it from types with the same name but different fields.

use std::collections::BTreeMap;

use sha2::{Digest, Sha256};

use crate::{
    definition::{Definition, Field},
    error::DefinitionError,
};

/// A set of interface definitions that provides the description of each defined type.
///
/// # Examples
///
/// ```
/// use rosidl::Definitions;
///
/// let definitions = Definitions::new([("my_msgs/srv/Ping", "---\nbool success")])?;
/// let request = definitions.describe("my_msgs/srv/Ping_Request").expect("the type is defined");
/// assert_eq!(request.main.fields[0].name, "structure_needs_at_least_one_member");
///
/// // The event message of a service uses a type from another package, which is not in this set.
/// assert_eq!(definitions.describe("my_msgs/srv/Ping"), None);
/// # Ok::<(), rosidl::DefinitionError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Definitions(BTreeMap<String, Type>);

/// The description of a type, without the types that it references, and the source of the type.
#[derive(Clone, Debug)]
struct Type {
    description: IndividualDescription,
    source: Source,
}

/// The description of a type, without the types that it references.
#[derive(Clone, Debug, PartialEq)]
pub struct IndividualDescription {
    /// The full name, e.g. `std_msgs/msg/Header`.
    pub type_name: String,
    /// The fields, in definition order.
    pub fields: Vec<Field>,
}

/// The description of a type and of all types that it references, directly or indirectly.
#[derive(Clone, Debug, PartialEq)]
pub struct Described {
    /// The described type.
    pub main: IndividualDescription,
    /// The referenced types, sorted by name.
    pub referenced: Vec<IndividualDescription>,
    /// The source of the described type, followed by the sources of the referenced types.
    pub sources: Vec<Source>,
}

/// The definition text of a type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The full name of the type.
    pub type_name: String,
    /// The format of the definition.
    pub encoding: SourceEncoding,
    /// The text of the definition; empty for an implicit definition.
    pub text: String,
}

/// The format of a definition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceEncoding {
    /// A `.msg` file.
    Msg,
    /// A `.srv` file.
    Srv,
    /// No file: the request, response or event message of a service, implied by its `.srv` file.
    Implicit,
}

impl SourceEncoding {
    /// Returns the name used by `type_description_interfaces/msg/TypeSource`.
    pub fn name(self) -> &'static str {
        match self {
            SourceEncoding::Msg => "msg",
            SourceEncoding::Srv => "srv",
            SourceEncoding::Implicit => "implicit",
        }
    }
}

impl Definitions {
    /// Parses definitions. Each is a pair of a full name, e.g. `std_msgs/msg/Header`, and the text
    /// of the definition.
    ///
    /// # Errors
    ///
    /// Returns [`DefinitionError`] if a name or a definition is invalid.
    pub fn new<'a>(
        definitions: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Definitions, DefinitionError> {
        let mut types = BTreeMap::new();
        for (name, text) in definitions {
            for r#type in types_of(name, text)? {
                types.insert(r#type.description.type_name.clone(), r#type);
            }
        }
        Ok(Definitions(types))
    }

    /// Returns the description of a type by its full name, e.g. `std_msgs/msg/Header` or
    /// `my_msgs/srv/Move_Request`.
    ///
    /// Returns `None` if the type, or a type that it references, is not defined in this set.
    pub fn describe(&self, full_name: &str) -> Option<Described> {
        let main = &self.0.get(full_name)?.description;
        let mut referenced = BTreeMap::new();
        let mut pending: Vec<&str> = nested(main).collect();
        while let Some(name) = pending.pop() {
            if !referenced.contains_key(name) {
                let found = self.0.get(name)?;
                pending.extend(nested(&found.description));
                referenced.insert(name, found);
            }
        }
        let sources = [&self.0[full_name]].into_iter().chain(referenced.values().copied());
        Some(Described {
            main: main.clone(),
            sources: sources.map(|found| found.source.clone()).collect(),
            referenced: referenced.values().map(|found| found.description.clone()).collect(),
        })
    }
}

/// Returns the types that a definition declares: a message, or a service and its three messages.
fn types_of(name: &str, text: &str) -> Result<Vec<Type>, DefinitionError> {
    let parts: Vec<&str> = name.split('/').collect();
    let make_type = |type_name: String, part: Definition, encoding, text: &str| Type {
        source: Source { type_name: type_name.clone(), encoding, text: text.to_owned() },
        description: IndividualDescription { type_name, fields: part.fields },
    };
    match parts[..] {
        [package, "msg", _] => {
            let parts = Definition::parse(package, text)?.into_iter();
            let message = |part| make_type(name.to_owned(), part, SourceEncoding::Msg, text);
            Ok(parts.map(message).collect())
        }
        [package, "srv", _] => {
            // rosidl describes a service as a type with three fields, and adds the event message
            // that service introspection publishes.
            let whole = format!(
                "{name}_Request request_message\n\
                 {name}_Response response_message\n\
                 {name}_Event event_message\n\
                 ---\n\
                 {text}\n\
                 ---\n\
                 service_msgs/ServiceEventInfo info\n\
                 {name}_Request[<=1] request\n\
                 {name}_Response[<=1] response"
            );
            let parts = Definition::parse(package, &whole)?;
            let suffixes = ["", "_Request", "_Response", "_Event"];
            let types = suffixes.into_iter().zip(parts).map(|(suffix, part)| match suffix {
                "" => make_type(name.to_owned(), part, SourceEncoding::Srv, text),
                _ => make_type(format!("{name}{suffix}"), part, SourceEncoding::Implicit, ""),
            });
            Ok(types.collect())
        }
        _ => Err(DefinitionError::Name(name.to_owned())),
    }
}

/// Returns the full names of the message types that the fields use.
fn nested(description: &IndividualDescription) -> impl Iterator<Item = &str> {
    let names = description.fields.iter().map(|field| field.r#type.nested_type_name());
    names.filter(|name| !name.is_empty())
}

impl Described {
    /// Returns the type hash: `RIHS01_`, followed by the SHA-256 of the description as 64
    /// hexadecimal digits.
    pub fn hash(&self) -> String {
        let referenced = joined(&self.referenced, json_of_type);
        let json = format!(
            r#"{{"type_description": {}, "referenced_type_descriptions": [{referenced}]}}"#,
            json_of_type(&self.main),
        );
        let digits =
            Sha256::digest(json).iter().map(|byte| format!("{byte:02x}")).collect::<String>();
        format!("RIHS01_{digits}")
    }
}

// The hash is computed over JSON as Python formats it, with a space after each comma and colon;
// serde_json does not write these spaces. Names contain only letters, digits, `_` and `/`, so no
// escaping is needed.

fn json_of_type(description: &IndividualDescription) -> String {
    let IndividualDescription { type_name, fields } = description;
    let fields = joined(fields, json_of_field);
    format!(r#"{{"type_name": "{type_name}", "fields": [{fields}]}}"#)
}

/// Omits the default value: it does not affect the wire format, so it is not part of the hash.
fn json_of_field(field: &Field) -> String {
    let r#type = &field.r#type;
    format!(
        r#"{{"name": "{}", "type": {{"type_id": {}, "capacity": {}, "string_capacity": {}, "nested_type_name": "{}"}}}}"#,
        field.name,
        r#type.id(),
        r#type.capacity(),
        r#type.string_capacity(),
        r#type.nested_type_name(),
    )
}

fn joined<T>(items: &[T], json: impl Fn(&T) -> String) -> String {
    items.iter().map(json).collect::<Vec<_>>().join(", ")
}
