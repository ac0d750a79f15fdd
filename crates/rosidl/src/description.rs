//! What a type looks like, and the hash that tells it from others of its name, as REP-2011 and
//! REP-2016 have them.

use std::collections::BTreeMap;

use sha2::{Digest, Sha256};

use crate::{
    definition::{Definition, Field},
    error::DefinitionError,
};

/// The definitions of some packages, by which types are described.
#[derive(Clone, Debug, Default)]
pub struct Definitions(BTreeMap<String, Type>);

/// A type by itself, and where it comes from.
#[derive(Clone, Debug)]
struct Type {
    description: IndividualDescription,
    source: Source,
}

/// A type by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct IndividualDescription {
    /// The full name, such as `std_msgs/msg/Header`.
    pub type_name: String,
    /// The fields, in their order.
    pub fields: Vec<Field>,
}

/// A type and those that it stands on.
#[derive(Clone, Debug, PartialEq)]
pub struct Described {
    /// The type.
    pub main: IndividualDescription,
    /// Those that it stands on, by their names.
    pub referenced: Vec<IndividualDescription>,
    /// What the type was defined by, then the others.
    pub sources: Vec<Source>,
}

/// What a type was defined by.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The full name of the type.
    pub type_name: String,
    /// How the definition is written.
    pub encoding: SourceEncoding,
    /// The definition; empty if it is implicit.
    pub text: String,
}

/// How a definition is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceEncoding {
    /// As a `.msg` file.
    Msg,
    /// As a `.srv` file.
    Srv,
    /// Not at all: the request, the response or the event of a service.
    Implicit,
}

impl SourceEncoding {
    /// As `type_description_interfaces/msg/TypeSource` names it.
    pub fn name(self) -> &'static str {
        match self {
            SourceEncoding::Msg => "msg",
            SourceEncoding::Srv => "srv",
            SourceEncoding::Implicit => "implicit",
        }
    }
}

impl Definitions {
    /// These definitions: full names, such as `std_msgs/msg/Header`, and texts.
    ///
    /// # Errors
    ///
    /// A name or a text is none of a definition.
    pub fn new<'a>(
        definitions: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Definitions, DefinitionError> {
        let mut types = BTreeMap::new();
        for (name, text) in definitions {
            for described in types_of(name, text)? {
                types.insert(described.description.type_name.clone(), described);
            }
        }
        Ok(Definitions(types))
    }

    /// The description of the type with this full name, such as `std_msgs/msg/Header` or
    /// `my_msgs/srv/Move_Request`; none if it, or one that it stands on, is not defined here.
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

/// The types that a definition makes: a message, or a service with its three messages.
fn types_of(name: &str, text: &str) -> Result<Vec<Type>, DefinitionError> {
    let parts: Vec<&str> = name.split('/').collect();
    let described = |type_name: String, part: Definition, encoding, text: &str| Type {
        source: Source { type_name: type_name.clone(), encoding, text: text.to_owned() },
        description: IndividualDescription { type_name, fields: part.fields },
    };
    match parts[..] {
        [package, "msg", _] => {
            let parts = Definition::parse(package, text)?.into_iter();
            let message = |part| described(name.to_owned(), part, SourceEncoding::Msg, text);
            Ok(parts.map(message).collect())
        }
        [package, "srv", _] => {
            // To what is written rosidl adds the service itself, and what its introspection publishes.
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
                "" => described(name.to_owned(), part, SourceEncoding::Srv, text),
                _ => described(format!("{name}{suffix}"), part, SourceEncoding::Implicit, ""),
            });
            Ok(types.collect())
        }
        _ => Err(DefinitionError::Name(name.to_owned())),
    }
}

/// The full names of the types of a type's fields.
fn nested(description: &IndividualDescription) -> impl Iterator<Item = &str> {
    let names = description.fields.iter().map(|field| field.r#type.nested_type_name());
    names.filter(|name| !name.is_empty())
}

impl Described {
    /// The hash of the description: `RIHS01_`, then SHA-256 in 64 hexadecimal digits.
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

// What is hashed is JSON as Python writes it, which serde_json does not: with a blank after each
// comma and colon. The names in it are letters, digits, `_` and `/`: nothing is to be escaped.

fn json_of_type(description: &IndividualDescription) -> String {
    let IndividualDescription { type_name, fields } = description;
    let fields = joined(fields, json_of_field);
    format!(r#"{{"type_name": "{type_name}", "fields": [{fields}]}}"#)
}

/// Default values are left out of the hash: who sends and who receives need not agree on them.
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
