//! Rust syntax for the types and values in definitions.

use std::collections::BTreeMap;

use crate::{
    definition::Field,
    error::GenerateError,
    field_type::{Element, FieldType, Primitive, Repetition},
};

/// The maximum length of arrays that implement `Default` and the serde traits.
const MAX_PLAIN_ARRAY: u64 = 32;

/// The known messages: maps each full name to the Rust path and the fields.
#[derive(Debug, Default)]
pub(crate) struct Types(BTreeMap<String, (String, Vec<Field>)>);

/// The traits that can be derived for a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Traits {
    pub(crate) is_copy: bool,
    pub(crate) is_eq: bool,
    /// Whether `Default` can be derived: every field defaults to the default of its Rust type.
    pub(crate) has_plain_default: bool,
}

impl Types {
    pub(crate) fn insert(&mut self, full_name: String, path: String, fields: Vec<Field>) {
        self.0.insert(full_name, (path, fields));
    }

    /// Returns the traits that can be derived for a message with these fields.
    pub(crate) fn traits_of(
        &self,
        full_name: &str,
        fields: &[Field],
    ) -> Result<Traits, GenerateError> {
        let mut traits = Traits { is_copy: true, is_eq: true, has_plain_default: true };
        for field in fields {
            let FieldType { element, repetition } = &field.r#type;
            match element {
                Element::Primitive(Primitive::Float32 | Primitive::Float64) => traits.is_eq = false,
                Element::Primitive(_) => {}
                Element::Text { wide: true, .. } => {
                    return Err(GenerateError::Unsupported {
                        name: full_name.to_owned(),
                        construct: format!("wstring {}", field.name),
                    });
                }
                Element::Text { .. } => traits.is_copy = false,
                Element::Message(nested) => {
                    let missing = || GenerateError::Missing {
                        name: full_name.to_owned(),
                        field: field.name.clone(),
                        missing: nested.clone(),
                    };
                    let (_, fields) = self.0.get(nested).ok_or_else(missing)?;
                    let nested = self.traits_of(nested, fields)?;
                    traits.is_copy &= nested.is_copy;
                    traits.is_eq &= nested.is_eq;
                }
            }
            traits.is_copy &= matches!(repetition, Repetition::Single | Repetition::Array(_));
            // An explicit default can equal the default of the Rust type.
            let is_plain = matches!(field.default.as_str(), "" | "0" | "false");
            traits.has_plain_default &= is_plain && !is_big_array(&field.r#type);
        }
        Ok(traits)
    }

    /// Returns the Rust type of a field. If it is a message, the message must be known.
    pub(crate) fn rust(&self, r#type: &FieldType) -> String {
        let element = match &r#type.element {
            Element::Primitive(primitive) => primitive.rust().to_owned(),
            Element::Text { .. } => "::std::string::String".to_owned(),
            Element::Message(name) => {
                self.0.get(name).map_or(name.clone(), |(path, _)| path.clone())
            }
        };
        match r#type.repetition {
            Repetition::Single => element,
            Repetition::Array(size) => format!("[{element}; {size}]"),
            Repetition::Bounded(_) | Repetition::Unbounded => format!("::std::vec::Vec<{element}>"),
        }
    }
}

impl Primitive {
    fn rust(self) -> &'static str {
        match self {
            Primitive::Bool => "bool",
            Primitive::Byte | Primitive::Uint8 => "u8",
            Primitive::Int8 => "i8",
            Primitive::Int16 => "i16",
            Primitive::Uint16 => "u16",
            Primitive::Int32 => "i32",
            Primitive::Uint32 => "u32",
            Primitive::Int64 => "i64",
            Primitive::Uint64 => "u64",
            Primitive::Float32 => "f32",
            Primitive::Float64 => "f64",
        }
    }
}

/// Returns whether a field needs `serde_big_array`.
pub(crate) fn is_big_array(r#type: &FieldType) -> bool {
    matches!(r#type.repetition, Repetition::Array(size) if size > MAX_PLAIN_ARRAY)
}

/// Returns the default value of a field as a Rust expression, or `None` if it is not supported.
pub(crate) fn default(field: &Field) -> Option<String> {
    const PLAIN: &str = "::std::default::Default::default()";
    let FieldType { element, repetition } = &field.r#type;
    match (field.default.as_str(), element, repetition) {
        ("", _, Repetition::Array(size)) if *size > MAX_PLAIN_ARRAY => {
            Some(format!("[{PLAIN}; {size}]"))
        }
        ("", ..) => Some(PLAIN.to_owned()),
        (value, Element::Primitive(primitive), Repetition::Single) => {
            Some(number(*primitive, value))
        }
        (value, Element::Text { .. }, Repetition::Single) => {
            Some(format!("{:?}.to_owned()", unquoted(value)))
        }
        _ => None,
    }
}

/// Returns the Rust type and value of a constant.
pub(crate) fn constant(r#type: &FieldType, value: &str) -> (&'static str, String) {
    match r#type.element {
        Element::Primitive(primitive) => (primitive.rust(), number(primitive, value)),
        Element::Text { .. } | Element::Message(_) => ("&str", format!("{:?}", unquoted(value))),
    }
}

/// Returns a number or boolean as a Rust literal.
fn number(primitive: Primitive, value: &str) -> String {
    match primitive {
        Primitive::Bool => value.to_lowercase(),
        Primitive::Float32 | Primitive::Float64 if value.parse::<i64>().is_ok() => {
            format!("{value}.0")
        }
        _ => value.to_owned(),
    }
}

/// Removes the quotes around a string.
fn unquoted(value: &str) -> &str {
    let inner = |quote| value.strip_prefix(quote).and_then(|value: &str| value.strip_suffix(quote));
    inner('"').or_else(|| inner('\'')).unwrap_or(value)
}

/// Returns the name of a field or module as a Rust identifier. Keywords become raw identifiers;
/// `crate`, `self` and `super`, which cannot be raw, get a trailing underscore.
pub(crate) fn identifier(name: &str) -> String {
    // The Rust Reference, "Keywords": strict and reserved keywords of edition 2024.
    const KEYWORDS: [&str; 48] = [
        "abstract", "as", "async", "await", "become", "box", "break", "const", "continue", "do",
        "dyn", "else", "enum", "extern", "false", "final", "fn", "for", "gen", "if", "impl", "in",
        "let", "loop", "macro", "match", "mod", "move", "mut", "override", "priv", "pub", "ref",
        "return", "static", "struct", "trait", "true", "try", "type", "typeof", "unsafe",
        "unsized", "use", "virtual", "where", "while", "yield",
    ];
    match name {
        "crate" | "self" | "super" => format!("{name}_"),
        _ if KEYWORDS.contains(&name) => format!("r#{name}"),
        _ => name.to_owned(),
    }
}

/// Converts a name to snake case, e.g. `GetTypeDescription` to `get_type_description`.
pub(crate) fn snake_case(name: &str) -> String {
    let mut text = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !text.is_empty() {
            text.push('_');
        }
        text.extend(letter.to_lowercase());
    }
    text
}
