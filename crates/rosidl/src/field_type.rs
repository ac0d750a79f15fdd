//! Field types.

use crate::error::DefinitionError;

/// The type of a field: the element type and the number of elements.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FieldType {
    /// The type of one element.
    pub element: Element,
    /// The number of elements, or their maximum number.
    pub repetition: Repetition,
}

/// The type of one element of a field.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Element {
    /// A number, a boolean or a byte.
    Primitive(Primitive),
    /// A string.
    Text {
        /// The maximum number of characters, if the string is bounded.
        bound: Option<u64>,
        /// Whether the characters are 16 bits wide (`wstring`).
        wide: bool,
    },
    /// A message, identified by its full name, e.g. `std_msgs/msg/Header`.
    Message(String),
}

/// A primitive type of fixed size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "named as in the definitions")]
pub enum Primitive {
    Bool,
    Byte,
    Int8,
    /// Also `char`, which rosidl maps to `uint8`.
    Uint8,
    Int16,
    Uint16,
    Int32,
    Uint32,
    Int64,
    Uint64,
    Float32,
    Float64,
}

/// The number of elements in a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repetition {
    /// One element.
    Single,
    /// `TYPE[N]`: an array of N elements.
    Array(u64),
    /// `TYPE[<=N]`: a sequence of at most N elements.
    Bounded(u64),
    /// `TYPE[]`: a sequence of any length.
    Unbounded,
}

impl FieldType {
    /// Parses a type as written in a definition, e.g. `uint8[]`, `string<=10` or `Pose[<=3]`.
    ///
    /// A message name without a package refers to a message in `package`.
    ///
    /// # Errors
    ///
    /// Returns [`DefinitionError::Size`] if a size is not a whole number.
    pub fn parse(package: &str, text: &str) -> Result<FieldType, DefinitionError> {
        let (element, repetition) = match text.strip_suffix(']').and_then(|t| t.split_once('[')) {
            None => (text, Repetition::Single),
            Some((element, "")) => (element, Repetition::Unbounded),
            Some((element, size)) => match size.strip_prefix("<=") {
                None => (element, Repetition::Array(parse_size(text, size)?)),
                Some(bound) => (element, Repetition::Bounded(parse_size(text, bound)?)),
            },
        };
        let (name, bound) = match element.split_once("<=") {
            None => (element, None),
            Some((name, bound)) => (name, Some(parse_size(text, bound)?)),
        };
        let element = match name {
            "bool" => Element::Primitive(Primitive::Bool),
            "byte" => Element::Primitive(Primitive::Byte),
            "int8" => Element::Primitive(Primitive::Int8),
            "uint8" | "char" => Element::Primitive(Primitive::Uint8),
            "int16" => Element::Primitive(Primitive::Int16),
            "uint16" => Element::Primitive(Primitive::Uint16),
            "int32" => Element::Primitive(Primitive::Int32),
            "uint32" => Element::Primitive(Primitive::Uint32),
            "int64" => Element::Primitive(Primitive::Int64),
            "uint64" => Element::Primitive(Primitive::Uint64),
            "float32" => Element::Primitive(Primitive::Float32),
            "float64" => Element::Primitive(Primitive::Float64),
            "string" => Element::Text { bound, wide: false },
            "wstring" => Element::Text { bound, wide: true },
            message => Element::Message(match message.split('/').count() {
                1 => format!("{package}/msg/{message}"),
                2 => message.replace('/', "/msg/"),
                _ => message.to_owned(),
            }),
        };
        Ok(FieldType { element, repetition })
    }

    /// Returns the type ID, one of the constants in `type_description_interfaces/msg/FieldType`.
    pub fn id(&self) -> u8 {
        let element = match &self.element {
            Element::Message(_) => 1,
            Element::Primitive(primitive) => primitive.id(),
            Element::Text { bound: None, wide: false } => 17,
            Element::Text { bound: None, wide: true } => 18,
            Element::Text { bound: Some(_), wide: false } => 21,
            Element::Text { bound: Some(_), wide: true } => 22,
        };
        // FieldType.msg adds these offsets to the ID of the element type.
        element
            + match self.repetition {
                Repetition::Single => 0,
                Repetition::Array(_) => 48,
                Repetition::Bounded(_) => 96,
                Repetition::Unbounded => 144,
            }
    }

    /// Returns the length of an array or the maximum length of a bounded sequence, and 0 otherwise.
    pub fn capacity(&self) -> u64 {
        match self.repetition {
            Repetition::Array(size) | Repetition::Bounded(size) => size,
            Repetition::Single | Repetition::Unbounded => 0,
        }
    }

    /// Returns the maximum length of a bounded string in characters, and 0 otherwise.
    pub fn string_capacity(&self) -> u64 {
        match self.element {
            Element::Text { bound, .. } => bound.unwrap_or(0),
            Element::Primitive(_) | Element::Message(_) => 0,
        }
    }

    /// Returns the full name of the message type, or an empty string for other types.
    pub fn nested_type_name(&self) -> &str {
        match &self.element {
            Element::Message(name) => name,
            Element::Primitive(_) | Element::Text { .. } => "",
        }
    }
}

impl Primitive {
    fn id(self) -> u8 {
        match self {
            Primitive::Int8 => 2,
            Primitive::Uint8 => 3,
            Primitive::Int16 => 4,
            Primitive::Uint16 => 5,
            Primitive::Int32 => 6,
            Primitive::Uint32 => 7,
            Primitive::Int64 => 8,
            Primitive::Uint64 => 9,
            Primitive::Float32 => 10,
            Primitive::Float64 => 11,
            Primitive::Bool => 15,
            Primitive::Byte => 16,
        }
    }
}

fn parse_size(type_name: &str, size: &str) -> Result<u64, DefinitionError> {
    size.parse().map_err(|_| DefinitionError::Size {
        type_name: type_name.to_owned(),
        size: size.to_owned(),
    })
}
