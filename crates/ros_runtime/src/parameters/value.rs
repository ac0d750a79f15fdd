//! Parameter values: their ROS types, their YAML format and their Rust types.

use std::{fmt, str::FromStr};

use ros_interfaces::rcl_interfaces::{ParameterType as Code, ParameterValue as Message};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::escape::escaped;

/// A value of one of the ROS parameter types.
///
/// In YAML, the literal determines the type of a value: `true`, `3`, `0.5`, `text`, or a list of
/// one of these. [`Display`](fmt::Display) describes the value on one line, for error messages.
///
/// # Examples
///
/// ```
/// use ros_runtime::parameters::ParameterValue;
///
/// assert_eq!(ParameterValue::Integer(3).to_string(), "the integer 3");
/// assert_eq!(ParameterValue::String("a\nb".to_owned()).to_string(), r"the string 'a\nb'");
/// ```
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
    /// Returns the type of this value.
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

    /// Converts this value to the expected type where YAML is ambiguous: an integer to a double, an
    /// array of integers to an array of doubles, a number to an array of one double, and an empty
    /// array to an array of any type.
    ///
    /// # Errors
    ///
    /// Returns the unchanged value if it has another type and cannot be converted.
    pub fn converted(self, expected: ParameterType) -> Result<ParameterValue, ParameterValue> {
        let empty = match &self {
            ParameterValue::BoolArray(items) => items.is_empty(),
            _ => false,
        };
        match (self, expected) {
            (value, expected) if value.kind() == expected => Ok(value),
            (ParameterValue::Integer(number), ParameterType::Double) => {
                Ok(ParameterValue::Double(number as f64))
            }
            (ParameterValue::Integer(number), ParameterType::DoubleArray) => {
                Ok(ParameterValue::DoubleArray(vec![number as f64]))
            }
            (ParameterValue::Double(number), ParameterType::DoubleArray) => {
                Ok(ParameterValue::DoubleArray(vec![number]))
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
            ParameterValue::String(value) => write!(f, "the string '{}'", escaped(value)),
            ParameterValue::BoolArray(values) => write!(f, "the list {values:?}"),
            ParameterValue::IntegerArray(values) => write!(f, "the list {values:?}"),
            ParameterValue::DoubleArray(values) => write!(f, "the list {values:?}"),
            ParameterValue::StringArray(values) => write!(f, "the list {values:?}"),
        }
    }
}

/// A Rust type for a parameter: `bool`, `i64`, `f64`, `String`, or a `Vec` of one of the last
/// three.
///
/// # Examples
///
/// ```
/// use ros_runtime::parameters::{FromParameter, ParameterValue};
///
/// let value = ParameterValue::DoubleArray(vec![0.5, 1.0]);
/// assert_eq!(Vec::<f64>::from_value(&value), Some(vec![0.5, 1.0]));
/// assert_eq!(i64::from_value(&value), None);
/// ```
pub trait FromParameter: Sized {
    /// The ROS type.
    const TYPE: ParameterType;
    /// Converts a Rust value to a ROS value.
    fn into_value(self) -> ParameterValue;
    /// Converts a ROS value to a Rust value. Returns `None` if it has another type.
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

/// A parameter override, as given with `-p`: `[node:]name:=value`.
///
/// # Examples
///
/// ```
/// use ros_runtime::parameters::{Override, ParameterValue};
///
/// let rule: Override = "camera:rate:=20.0".parse()?;
/// assert_eq!((rule.node.as_deref(), rule.name.as_str()), (Some("camera"), "rate"));
/// assert_eq!(rule.value, ParameterValue::Double(20.0));
/// # Ok::<(), ros_runtime::parameters::OverrideError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Override {
    /// The name of the node to which the override applies; `None` for every node.
    pub node: Option<String>,
    /// The name of the parameter.
    pub name: String,
    /// The value.
    pub value: ParameterValue,
}

/// The error returned for an invalid parameter override.
#[derive(Debug, Error, PartialEq)]
#[error(
    "couldn't parse the parameter override '{}': expected 'name:=value' or 'node:name:=value' \
     with a value in YAML, such as 3, 0.5, true, text or [1.0, 2.0]",
    escaped(.0)
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
        // `-p name:=` sets an empty string; in YAML, an empty value would be null.
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

/// Converts to the value that ros2-client's node publishes on `/parameter_events`.
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
    /// Returns the corresponding constant of `rcl_interfaces/ParameterType`.
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
    /// Returns the value in a message, or `None` for "not set" and for byte arrays, which are not
    /// supported.
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
    fn the_literal_of_a_value_determines_its_type() {
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
    fn converts_values_to_messages_and_back() {
        for rule in ["a:=true", "a:=3", "a:=0.5", "a:=x", "a:=[1]", "a:=[1.5]", "a:=[x]"] {
            let message = Message::from(value(rule));
            assert_eq!(ParameterValue::from_message(&message), Some(value(rule)));
        }
    }

    #[test]
    fn describes_values_on_one_line() {
        let texts = vec!["a\nb".to_owned(), "c".to_owned()];
        for (value, expected) in [
            (ParameterValue::Bool(true), "true"),
            (ParameterValue::Double(0.5), "the number 0.5"),
            (ParameterValue::String("it's größer".into()), "the string 'it's größer'"),
            (ParameterValue::String("0\ne\r\n\u{1b}".into()), r"the string '0\ne\r\n\u{1b}'"),
            (ParameterValue::StringArray(texts), r#"the list ["a\nb", "c"]"#),
        ] {
            assert_eq!(value.to_string(), expected);
        }
    }

    #[test]
    fn errors_escape_the_override_that_they_quote() {
        let error = "a\nb".parse::<Override>().unwrap_err().to_string();
        let expected = "couldn't parse the parameter override 'a\\nb': expected 'name:=value' or \
                        'node:name:=value' with a value in YAML, such as 3, 0.5, true, text or \
                        [1.0, 2.0]";
        assert_eq!(error, expected);
    }
}
