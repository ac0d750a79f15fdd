//! The type of a field.

use crate::error::DefinitionError;

/// The type of a field: an element, once or repeated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FieldType {
    /// What is repeated.
    pub element: Element,
    /// How often.
    pub repetition: Repetition,
}

/// What a field holds, once or repeated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Element {
    /// A number, a truth value or a byte.
    Primitive(Primitive),
    /// Text with an optional maximum number of characters.
    Text {
        /// The bound.
        bound: Option<u64>,
        /// Whether it is of 16-bit characters.
        wide: bool,
    },
    /// A message, by its full name, such as `std_msgs/msg/Header`.
    Message(String),
}

/// A type of fixed size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "named as in the definitions")]
pub enum Primitive {
    Bool,
    Byte,
    Int8,
    /// Also ROS 1's `char`, as rosidl takes it.
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

/// How often an element stands in a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repetition {
    /// Once.
    Single,
    /// `TYPE[N]`: N times.
    Array(u64),
    /// `TYPE[<=N]`: at most N times.
    Bounded(u64),
    /// `TYPE[]`: any number of times.
    Unbounded,
}

impl FieldType {
    /// The type that a definition of a package writes so, such as `uint8[]`, `string<=10` or
    /// `Pose[<=3]`.
    ///
    /// # Errors
    ///
    /// A size is no number.
    pub fn parse(package: &str, written: &str) -> Result<FieldType, DefinitionError> {
        let (element, repetition) = match written.strip_suffix(']').and_then(|w| w.split_once('['))
        {
            None => (written, Repetition::Single),
            Some((element, "")) => (element, Repetition::Unbounded),
            Some((element, size)) => match size.strip_prefix("<=") {
                None => (element, Repetition::Array(number(written, size)?)),
                Some(bound) => (element, Repetition::Bounded(number(written, bound)?)),
            },
        };
        let (name, bound) = match element.split_once("<=") {
            None => (element, None),
            Some((name, bound)) => (name, Some(number(written, bound)?)),
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

    /// The number of the type in `type_description_interfaces/msg/FieldType`.
    pub fn id(&self) -> u8 {
        let element = match &self.element {
            Element::Message(_) => 1,
            Element::Primitive(primitive) => primitive.id(),
            Element::Text { bound: None, wide: false } => 17,
            Element::Text { bound: None, wide: true } => 18,
            Element::Text { bound: Some(_), wide: false } => 21,
            Element::Text { bound: Some(_), wide: true } => 22,
        };
        // ROS has a constant for each sum.
        element
            + match self.repetition {
                Repetition::Single => 0,
                Repetition::Array(_) => 48,
                Repetition::Bounded(_) => 96,
                Repetition::Unbounded => 144,
            }
    }

    /// The length of an array or the greatest length of a bounded sequence, otherwise 0.
    pub fn capacity(&self) -> u64 {
        match self.repetition {
            Repetition::Array(size) | Repetition::Bounded(size) => size,
            Repetition::Single | Repetition::Unbounded => 0,
        }
    }

    /// The greatest length of a bounded string, otherwise 0.
    pub fn string_capacity(&self) -> u64 {
        match self.element {
            Element::Text { bound, .. } => bound.unwrap_or(0),
            Element::Primitive(_) | Element::Message(_) => 0,
        }
    }

    /// The full name of the message that the field holds, otherwise empty.
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

fn number(written: &str, digits: &str) -> Result<u64, DefinitionError> {
    digits
        .parse()
        .map_err(|_| DefinitionError::Size { written: written.to_owned(), size: digits.to_owned() })
}
