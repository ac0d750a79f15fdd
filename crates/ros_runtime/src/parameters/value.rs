//! Values of parameters: their types, their YAML, and their Rust counterparts.

use std::{fmt, str::FromStr};

use ros_interfaces::rcl_interfaces::{ParameterType as Code, ParameterValue as Message};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A value of one of ROS's parameter types. In YAML it is what it looks like: `true`, `3`, `0.5`,
/// `text`, or a list of one of these.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ParameterValue {
    /// `bool`
    Bool(bool),
    /// `integer`, 64 bits
    Integer(i64),
    /// `double`
    Double(f64),
    /// `string`
    String(String),
    /// `bool_array`
    BoolArray(Vec<bool>),
    /// `integer_array`
    IntegerArray(Vec<i64>),
    /// `double_array`
    DoubleArray(Vec<f64>),
    /// `string_array`
    StringArray(Vec<String>),
}

/// The type of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterType {
    /// `bool`
    Bool,
    /// `integer`
    Integer,
    /// `double`
    Double,
    /// `string`
    String,
    /// `bool_array`
    BoolArray,
    /// `integer_array`
    IntegerArray,
    /// `double_array`
    DoubleArray,
    /// `string_array`
    StringArray,
}

impl ParameterValue {
    /// The type of this value.
    pub fn kind(&self) -> ParameterType {
        match self {
            ParameterValue::Bool(_) => ParameterType::Bool,
            ParameterValue::Integer(_) => ParameterType::Integer,
            ParameterValue::Double(_) => ParameterType::Double,
            ParameterValue::String(_) => ParameterType::String,
            ParameterValue::BoolArray(_) => ParameterType::BoolArray,
            ParameterValue::IntegerArray(_) => ParameterType::IntegerArray,
            ParameterValue::DoubleArray(_) => ParameterType::DoubleArray,
            ParameterValue::StringArray(_) => ParameterType::StringArray,
        }
    }

    /// The same value as the wanted type; the value itself if it has no such form.
    ///
    /// `3` is a double for a parameter that is declared as one, and `[]` an empty array of any
    /// type: YAML cannot say which is meant. Nothing else is converted.
    pub fn converted(self, wanted: ParameterType) -> Result<ParameterValue, ParameterValue> {
        let empty = match &self {
            ParameterValue::BoolArray(items) => items.is_empty(),
            _ => false,
        };
        match (self, wanted) {
            (value, wanted) if value.kind() == wanted => Ok(value),
            (ParameterValue::Integer(number), ParameterType::Double) => {
                Ok(ParameterValue::Double(number as f64))
            }
            (ParameterValue::IntegerArray(numbers), ParameterType::DoubleArray) => {
                Ok(ParameterValue::DoubleArray(numbers.iter().map(|n| *n as f64).collect()))
            }
            (_, ParameterType::IntegerArray) if empty => Ok(ParameterValue::IntegerArray(vec![])),
            (_, ParameterType::DoubleArray) if empty => Ok(ParameterValue::DoubleArray(vec![])),
            (_, ParameterType::StringArray) if empty => Ok(ParameterValue::StringArray(vec![])),
            (value, _) => Err(value),
        }
    }

    pub(super) fn numbers(&self) -> Vec<f64> {
        match self {
            ParameterValue::Integer(number) => vec![*number as f64],
            ParameterValue::Double(number) => vec![*number],
            ParameterValue::IntegerArray(numbers) => numbers.iter().map(|n| *n as f64).collect(),
            ParameterValue::DoubleArray(numbers) => numbers.clone(),
            _ => vec![],
        }
    }
}

impl fmt::Display for ParameterType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            ParameterType::Bool => "true or false",
            ParameterType::Integer => "an integer",
            ParameterType::Double => "a number",
            ParameterType::String => "a string",
            ParameterType::BoolArray => "a list of true and false",
            ParameterType::IntegerArray => "a list of integers",
            ParameterType::DoubleArray => "a list of numbers",
            ParameterType::StringArray => "a list of strings",
        })
    }
}

impl fmt::Display for ParameterValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ParameterValue::Bool(value) => write!(f, "{value}"),
            ParameterValue::Integer(value) => write!(f, "the integer {value}"),
            ParameterValue::Double(value) => write!(f, "the number {value}"),
            ParameterValue::String(value) => write!(f, "the string '{value}'"),
            ParameterValue::BoolArray(values) => write!(f, "the list {values:?}"),
            ParameterValue::IntegerArray(values) => write!(f, "the list {values:?}"),
            ParameterValue::DoubleArray(values) => write!(f, "the list {values:?}"),
            ParameterValue::StringArray(values) => write!(f, "the list {values:?}"),
        }
    }
}

/// A Rust type that a parameter can have.
pub trait FromParameter: Sized {
    /// The ROS type that it stands for.
    const TYPE: ParameterType;
    /// The value as ROS's.
    fn into_value(self) -> ParameterValue;
    /// The value as Rust's, if it is of this type.
    fn from_value(value: &ParameterValue) -> Option<Self>;
}

macro_rules! from_parameter {
    ($($rust:ty => $variant:ident),*) => {$(
        impl FromParameter for $rust {
            const TYPE: ParameterType = ParameterType::$variant;
            fn into_value(self) -> ParameterValue {
                ParameterValue::$variant(self)
            }
            fn from_value(value: &ParameterValue) -> Option<$rust> {
                match value {
                    ParameterValue::$variant(value) => Some(value.clone()),
                    _ => None,
                }
            }
        }
    )*};
}

from_parameter!(
    bool => Bool, i64 => Integer, f64 => Double, String => String,
    Vec<i64> => IntegerArray, Vec<f64> => DoubleArray, Vec<String> => StringArray
);

/// One `-p` rule: `[node:]name:=value`.
#[derive(Clone, Debug, PartialEq)]
pub struct Override {
    /// The node that it is for; every node if there is none.
    pub node: Option<String>,
    /// The parameter.
    pub name: String,
    /// Its value.
    pub value: ParameterValue,
}

/// Why a text is not a parameter override.
#[derive(Debug, Error, PartialEq)]
#[error(
    "couldn't parse the parameter override '{0}': expected 'name:=value' or 'node:name:=value' \
     with a value in YAML, such as 3, 0.5, true, text or [1.0, 2.0]"
)]
pub struct OverrideError(String);

impl FromStr for Override {
    type Err = OverrideError;

    fn from_str(rule: &str) -> Result<Override, OverrideError> {
        let error = || OverrideError(rule.to_owned());
        let (name, value) = rule.split_once(":=").ok_or_else(error)?;
        let (node, name) = match name.split_once(':') {
            Some((node, name)) => (Some(node.to_owned()), name),
            None => (None, name),
        };
        if name.is_empty() || node.as_ref().is_some_and(String::is_empty) {
            return Err(error());
        }
        // An empty value is the empty string: `-p scenario:=` would else be a YAML null.
        let value = match value {
            "" => ParameterValue::String(String::new()),
            yaml => serde_saphyr::from_str(yaml).map_err(|_| error())?,
        };
        Ok(Override { node, name: name.to_owned(), value })
    }
}

impl From<ParameterValue> for Message {
    fn from(value: ParameterValue) -> Message {
        let mut message = Message { r#type: value.kind().code(), ..Message::default() };
        match value {
            ParameterValue::Bool(value) => message.bool_value = value,
            ParameterValue::Integer(value) => message.integer_value = value,
            ParameterValue::Double(value) => message.double_value = value,
            ParameterValue::String(value) => message.string_value = value,
            ParameterValue::BoolArray(values) => message.bool_array_value = values,
            ParameterValue::IntegerArray(values) => message.integer_array_value = values,
            ParameterValue::DoubleArray(values) => message.double_array_value = values,
            ParameterValue::StringArray(values) => message.string_array_value = values,
        }
        message
    }
}

/// As ros2-client's node takes it for `/parameter_events`.
impl From<ParameterValue> for ros2_client::ParameterValue {
    fn from(value: ParameterValue) -> ros2_client::ParameterValue {
        use ros2_client::ParameterValue as Event;
        match value {
            ParameterValue::Bool(value) => Event::Boolean(value),
            ParameterValue::Integer(value) => Event::Integer(value),
            ParameterValue::Double(value) => Event::Double(value),
            ParameterValue::String(value) => Event::String(value),
            ParameterValue::BoolArray(values) => Event::BooleanArray(values),
            ParameterValue::IntegerArray(values) => Event::IntegerArray(values),
            ParameterValue::DoubleArray(values) => Event::DoubleArray(values),
            ParameterValue::StringArray(values) => Event::StringArray(values),
        }
    }
}

impl ParameterType {
    /// The constant of rcl_interfaces/ParameterType.
    pub(super) fn code(self) -> u8 {
        match self {
            ParameterType::Bool => Code::PARAMETER_BOOL,
            ParameterType::Integer => Code::PARAMETER_INTEGER,
            ParameterType::Double => Code::PARAMETER_DOUBLE,
            ParameterType::String => Code::PARAMETER_STRING,
            ParameterType::BoolArray => Code::PARAMETER_BOOL_ARRAY,
            ParameterType::IntegerArray => Code::PARAMETER_INTEGER_ARRAY,
            ParameterType::DoubleArray => Code::PARAMETER_DOUBLE_ARRAY,
            ParameterType::StringArray => Code::PARAMETER_STRING_ARRAY,
        }
    }
}

impl ParameterValue {
    /// The value of a message; `None` for "not set" and for byte arrays, which are not supported.
    pub fn from_message(message: &Message) -> Option<ParameterValue> {
        Some(match message.r#type {
            Code::PARAMETER_BOOL => ParameterValue::Bool(message.bool_value),
            Code::PARAMETER_INTEGER => ParameterValue::Integer(message.integer_value),
            Code::PARAMETER_DOUBLE => ParameterValue::Double(message.double_value),
            Code::PARAMETER_STRING => ParameterValue::String(message.string_value.clone()),
            Code::PARAMETER_BOOL_ARRAY => {
                ParameterValue::BoolArray(message.bool_array_value.clone())
            }
            Code::PARAMETER_INTEGER_ARRAY => {
                ParameterValue::IntegerArray(message.integer_array_value.clone())
            }
            Code::PARAMETER_DOUBLE_ARRAY => {
                ParameterValue::DoubleArray(message.double_array_value.clone())
            }
            Code::PARAMETER_STRING_ARRAY => {
                ParameterValue::StringArray(message.string_array_value.clone())
            }
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(rule: &str) -> ParameterValue {
        rule.parse::<Override>().unwrap().value
    }

    #[test]
    fn a_value_is_what_it_looks_like() {
        assert_eq!(value("a:=true"), ParameterValue::Bool(true));
        assert_eq!(value("a:=3"), ParameterValue::Integer(3));
        assert_eq!(value("a:=-0.5"), ParameterValue::Double(-0.5));
        assert_eq!(value("a:=1e-4"), ParameterValue::Double(1e-4));
        assert_eq!(value("a:=text"), ParameterValue::String("text".into()));
        assert_eq!(value("a:='3'"), ParameterValue::String("3".into()));
        assert_eq!(value("a:=runs/one"), ParameterValue::String("runs/one".into()));
        assert_eq!(value("a:="), ParameterValue::String("".into()));
        assert_eq!(value("a:=[1.0, 2.5]"), ParameterValue::DoubleArray(vec![1.0, 2.5]));
        assert_eq!(value("a:=[1, 2]"), ParameterValue::IntegerArray(vec![1, 2]));
        assert_eq!(value("a:=[a, b]"), ParameterValue::StringArray(vec!["a".into(), "b".into()]));
    }

    #[test]
    fn values_survive_the_wire() {
        for rule in ["a:=true", "a:=3", "a:=0.5", "a:=x", "a:=[1]", "a:=[1.5]", "a:=[x]"] {
            let message = Message::from(value(rule));
            assert_eq!(ParameterValue::from_message(&message), Some(value(rule)));
        }
    }
}
