//! The definitions of messages and services, in the language of `.msg` and `.srv` files
//! (<https://docs.ros.org/en/jazzy/Concepts/Basic/About-Interfaces.html>).

use crate::type_description_interfaces::{Field, FieldType};

/// The full name of one of our own definitions, such as `evac_msgs/msg/QValues`, and its text.
macro_rules! own {
    ($kind:literal, $name:literal) => {
        (
            concat!("evac_msgs/", $kind, "/", $name),
            include_str!(concat!("../", $kind, "/", $name, ".", $kind)),
        )
    };
}

const OWN: [(&str, &str); 6] = [
    own!("msg", "ActionCommand"),
    own!("msg", "EpisodeStatus"),
    own!("msg", "QValues"),
    own!("msg", "TrainingStatus"),
    own!("srv", "Reset"),
    own!("srv", "Step"),
];

/// The definitions of other packages that Evac needs, as ROS 2 Jazzy has them (common_interfaces,
/// geometry2, rcl_interfaces and rmw_dds_common), without comments; each comes after a line with its full name.
const STANDARD: &str = include_str!("standard_definitions.txt");

/// What stands before a name in [`STANDARD`].
const HEADING: &str = "=== ";

/// Every definition: its full name, such as `std_msgs/msg/Header`, and its text.
pub fn definitions() -> impl Iterator<Item = (&'static str, &'static str)> {
    let standard = STANDARD.split(HEADING).filter_map(|section| section.split_once('\n'));
    OWN.into_iter().chain(standard).map(|(name, text)| (name, text.trim_end()))
}

/// What a definition says of a message, or of one half of a service.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Definition {
    /// Name and value of each constant, as they are written.
    pub constants: Vec<(String, String)>,
    /// The fields, in their order.
    pub fields: Vec<Field>,
}

impl Definition {
    /// Reads a definition of a package: one of a message, the request and the response of a service.
    ///
    /// Panics if the size of an array or of a string is no number; there is none such in
    /// [`definitions`].
    pub fn parse(package: &str, text: &str) -> Vec<Definition> {
        let lines: Vec<&str> = text.lines().collect();
        let parts = lines.split(|line| *line == "---");
        parts.map(|lines| Definition::of_lines(package, lines)).collect()
    }

    fn of_lines(package: &str, lines: &[&str]) -> Definition {
        let mut definition = Definition::default();
        for line in lines {
            let line = line.split('#').next().unwrap_or_default().trim();
            // Otherwise the line is empty, or a comment.
            if let Some((written, rest)) = line.split_once(' ') {
                match rest.split_once('=') {
                    Some((name, value)) => {
                        let constant = (name.trim().to_owned(), value.trim().to_owned());
                        definition.constants.push(constant);
                    }
                    None => definition.fields.push(field(package, written, rest.trim())),
                }
            }
        }
        if definition.fields.is_empty() {
            // A struct of IDL cannot be empty, so rosidl puts this into it.
            definition.fields.push(field(package, "uint8", "structure_needs_at_least_one_member"));
        }
        definition
    }
}

/// The field with this type and, after its name, perhaps a default value.
fn field(package: &str, written: &str, rest: &str) -> Field {
    let (name, default) = rest.split_once(' ').unwrap_or((rest, ""));
    let r#type = field_type(package, written);
    let default_value = default_value(r#type.type_id, default.trim());
    Field { name: name.to_owned(), r#type, default_value }
}

/// The type that is written so, such as `uint8[]`, `string<=10` or `Pose[<=3]`.
fn field_type(package: &str, written: &str) -> FieldType {
    let (element, offset, capacity) = match written.trim_end_matches(']').split_once('[') {
        None => (written, 0, 0),
        Some((element, "")) => (element, FieldType::UNBOUNDED_SEQUENCE, 0),
        Some((element, size)) => match size.strip_prefix("<=") {
            None => (element, FieldType::ARRAY, number(size)),
            Some(bound) => (element, FieldType::BOUNDED_SEQUENCE, number(bound)),
        },
    };
    let (element, string_capacity) = match element.split_once("<=") {
        None => (element, 0),
        Some((element, bound)) => (element, number(bound)),
    };
    let type_id = match (element, string_capacity) {
        ("bool", _) => FieldType::FIELD_TYPE_BOOLEAN,
        ("byte", _) => FieldType::FIELD_TYPE_BYTE,
        ("int8", _) => FieldType::FIELD_TYPE_INT8,
        // As rosidl takes ROS 1's `char`.
        ("uint8" | "char", _) => FieldType::FIELD_TYPE_UINT8,
        ("int16", _) => FieldType::FIELD_TYPE_INT16,
        ("uint16", _) => FieldType::FIELD_TYPE_UINT16,
        ("int32", _) => FieldType::FIELD_TYPE_INT32,
        ("uint32", _) => FieldType::FIELD_TYPE_UINT32,
        ("int64", _) => FieldType::FIELD_TYPE_INT64,
        ("uint64", _) => FieldType::FIELD_TYPE_UINT64,
        ("float32", _) => FieldType::FIELD_TYPE_FLOAT,
        ("float64", _) => FieldType::FIELD_TYPE_DOUBLE,
        ("string", 0) => FieldType::FIELD_TYPE_STRING,
        ("string", _) => FieldType::FIELD_TYPE_BOUNDED_STRING,
        ("wstring", 0) => FieldType::FIELD_TYPE_WSTRING,
        ("wstring", _) => FieldType::FIELD_TYPE_BOUNDED_WSTRING,
        _ => FieldType::FIELD_TYPE_NESTED_TYPE,
    };
    let nested_type_name = match (type_id, element.split('/').count()) {
        (FieldType::FIELD_TYPE_NESTED_TYPE, 1) => format!("{package}/msg/{element}"),
        (FieldType::FIELD_TYPE_NESTED_TYPE, 2) => element.replace('/', "/msg/"),
        (FieldType::FIELD_TYPE_NESTED_TYPE, _) => element.to_owned(),
        _ => String::new(),
    };
    FieldType { type_id: type_id + offset, capacity, string_capacity, nested_type_name }
}

fn number(digits: &str) -> u64 {
    digits.parse().expect("the size of an array or of a string is a whole number")
}

/// A default value as rosidl puts it into a description: as Python writes it.
fn default_value(type_id: u8, written: &str) -> String {
    match type_id {
        FieldType::FIELD_TYPE_BOOLEAN => written.replace("true", "True").replace("false", "False"),
        FieldType::FIELD_TYPE_FLOAT | FieldType::FIELD_TYPE_DOUBLE => {
            match written.parse::<f64>() {
                Ok(number) => format!("{number:?}"),
                Err(_) => written.to_owned(),
            }
        }
        _ => written.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_line_may_say() {
        let text = "# a comment\n\nuint8 LEAST=1 # another\nchar[4] name\nstring<=8[<=2] words\n\
                    Inner[] inner\nother_msgs/Outer outer\nfloat64 w 1\nbool on true\nint8 x -2";
        let [definition] = &Definition::parse("our_msgs", text)[..] else {
            panic!("one message");
        };
        assert_eq!(definition.constants, [("LEAST".to_owned(), "1".to_owned())]);
        let fields = definition.fields.iter().map(|field| {
            let FieldType { type_id, capacity, string_capacity, nested_type_name } = &field.r#type;
            let numbers = (*type_id, *capacity, *string_capacity);
            (field.name.as_str(), numbers, nested_type_name.as_str(), field.default_value.as_str())
        });
        let expected = [
            ("name", (51, 4, 0), "", ""),
            ("words", (117, 2, 8), "", ""),
            ("inner", (145, 0, 0), "our_msgs/msg/Inner", ""),
            ("outer", (1, 0, 0), "other_msgs/msg/Outer", ""),
            ("w", (11, 0, 0), "", "1.0"),
            ("on", (15, 0, 0), "", "True"),
            ("x", (2, 0, 0), "", "-2"),
        ];
        assert_eq!(fields.collect::<Vec<_>>(), expected);
    }

    #[test]
    fn a_service_has_two_halves_and_an_empty_one_has_a_member() {
        let [request, response] = &Definition::parse("our_msgs", "---\nbool success")[..] else {
            panic!("a request and a response");
        };
        assert_eq!(request.fields[0].name, "structure_needs_at_least_one_member");
        assert_eq!(response.fields[0].name, "success");
    }
}
