//! What a type looks like, and the hash that tells it from others of its name, as REP-2011 and
//! REP-2016 have them.

use std::{collections::BTreeMap, sync::LazyLock};

use sha2::{Digest, Sha256};

use crate::{
    definition::{Definition, definitions},
    type_description_interfaces::{
        Field, FieldType, IndividualTypeDescription, TypeDescription, TypeSource,
    },
};

/// A type by itself, and where it comes from.
struct Type {
    description: IndividualTypeDescription,
    source: TypeSource,
}

/// Every type of every definition, by its full name.
static TYPES: LazyLock<BTreeMap<String, Type>> = LazyLock::new(|| {
    let types = definitions().flat_map(|(name, text)| types_of(name, text));
    types.map(|described| (described.description.type_name.clone(), described)).collect()
});

impl Type {
    fn new(type_name: String, fields: Vec<Field>, encoding: &str, text: &str) -> Type {
        let source = TypeSource {
            type_name: type_name.clone(),
            encoding: encoding.to_owned(),
            raw_file_contents: text.to_owned(),
        };
        Type { description: IndividualTypeDescription { type_name, fields }, source }
    }
}

/// The types that a definition makes: a message, or a service with its three messages.
fn types_of(name: &str, text: &str) -> Vec<Type> {
    let package = name.split('/').next().unwrap_or_default();
    if name.contains("/msg/") {
        let parts = Definition::parse(package, text).into_iter();
        let message =
            |part: Definition| Type::new(name.to_owned(), part.fields, TypeSource::MSG, text);
        return parts.map(message).collect();
    }
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
    let parts = Definition::parse(package, &whole);
    let types = ["", "_Request", "_Response", "_Event"].into_iter().zip(parts);
    let described = types.map(|(suffix, part)| {
        let (encoding, text) =
            if suffix.is_empty() { (TypeSource::SRV, text) } else { (TypeSource::IMPLICIT, "") };
        Type::new(format!("{name}{suffix}"), part.fields, encoding, text)
    });
    described.collect()
}

impl TypeDescription {
    /// The description of the type with this full name, such as `std_msgs/msg/Header` or
    /// `evac_msgs/srv/Step`; none for a type that Evac does not know.
    pub fn of(full_name: &str) -> Option<TypeDescription> {
        let type_description = TYPES.get(full_name)?.description.clone();
        let mut referenced = BTreeMap::new();
        let mut pending: Vec<&str> = nested(&type_description).collect();
        while let Some(name) = pending.pop() {
            if !referenced.contains_key(name) {
                let description = &TYPES.get(name)?.description;
                pending.extend(nested(description));
                referenced.insert(name, description.clone());
            }
        }
        let referenced_type_descriptions = referenced.into_values().collect();
        Some(TypeDescription { type_description, referenced_type_descriptions })
    }

    /// The hash of the description: `RIHS01_`, then SHA-256 in 64 hexadecimal digits.
    pub fn hash(&self) -> String {
        let referenced = joined(&self.referenced_type_descriptions, json_of_type);
        let json = format!(
            r#"{{"type_description": {}, "referenced_type_descriptions": [{referenced}]}}"#,
            json_of_type(&self.type_description),
        );
        let digits =
            Sha256::digest(json).iter().map(|byte| format!("{byte:02x}")).collect::<String>();
        format!("RIHS01_{digits}")
    }

    /// The definitions of the type and of those that it stands on, in the order of the description.
    /// Those of the standard types have no comments.
    pub fn sources(&self) -> Vec<TypeSource> {
        let types = [&self.type_description].into_iter().chain(&self.referenced_type_descriptions);
        types
            .filter_map(|described| Some(TYPES.get(&described.type_name)?.source.clone()))
            .collect()
    }
}

/// The full names of the types of a type's fields.
fn nested(description: &IndividualTypeDescription) -> impl Iterator<Item = &str> {
    let names = description.fields.iter().map(|field| field.r#type.nested_type_name.as_str());
    names.filter(|name| !name.is_empty())
}

// What is hashed is JSON as Python writes it, which serde_json does not: with a blank after each
// comma and colon. The names in it are letters, digits, `_` and `/`: nothing is to be escaped.

fn json_of_type(description: &IndividualTypeDescription) -> String {
    let IndividualTypeDescription { type_name, fields } = description;
    let fields = joined(fields, json_of_field);
    format!(r#"{{"type_name": "{type_name}", "fields": [{fields}]}}"#)
}

/// Default values are left out of the hash: who sends and who receives need not agree on them.
fn json_of_field(field: &Field) -> String {
    let Field { name, r#type, default_value: _ } = field;
    let FieldType { type_id, capacity, string_capacity, nested_type_name } = r#type;
    format!(
        r#"{{"name": "{name}", "type": {{"type_id": {type_id}, "capacity": {capacity}, "string_capacity": {string_capacity}, "nested_type_name": "{nested_type_name}"}}}}"#
    )
}

fn joined<T>(items: &[T], json: impl Fn(&T) -> String) -> String {
    items.iter().map(json).collect::<Vec<_>>().join(", ")
}
