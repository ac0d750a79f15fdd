//! Parses interface definitions.

use crate::{
    error::DefinitionError,
    field_type::{Element, FieldType, Primitive},
};

/// A parsed message, or the request or response of a parsed service.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Definition {
    /// The lines of the comment at the top of the definition; empty unless a blank line follows the
    /// comment.
    pub comment: Vec<String>,
    /// The constants, in definition order.
    pub constants: Vec<Constant>,
    /// The fields, in definition order.
    pub fields: Vec<Field>,
}

/// A constant of a message.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// The lines of the comment above, or, if there is none, the comment at the end of the line.
    pub comment: Vec<String>,
    /// The name.
    pub name: String,
    /// The type.
    pub r#type: FieldType,
    /// The value, as written.
    pub value: String,
}

/// A field of a message.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// The lines of the comment above, or, if there is none, the comment at the end of the line.
    pub comment: Vec<String>,
    /// The name.
    pub name: String,
    /// The type.
    pub r#type: FieldType,
    /// The default value, as written; empty if there is none.
    pub default: String,
}

impl Definition {
    /// Parses a definition from the ROS package `package`.
    ///
    /// The result has one element for a message and two (request and response) for a service.
    ///
    /// # Errors
    ///
    /// Returns [`DefinitionError`] if a line is neither a field nor a constant, or if a size in
    /// a type is not a whole number.
    ///
    /// # Examples
    ///
    /// ```
    /// use rosidl::Definition;
    ///
    /// let parts = Definition::parse("my_msgs", "uint8 action\n---\nbool success")?;
    /// assert_eq!(parts[0].fields[0].name, "action");
    /// assert_eq!(parts[1].fields[0].name, "success");
    /// # Ok::<(), rosidl::DefinitionError>(())
    /// ```
    pub fn parse(package: &str, text: &str) -> Result<Vec<Definition>, DefinitionError> {
        let lines: Vec<&str> = text.lines().collect();
        let parts = lines.split(|line| line.trim_end() == "---");
        parts.map(|lines| Definition::parse_lines(package, lines)).collect()
    }

    fn parse_lines(package: &str, lines: &[&str]) -> Result<Definition, DefinitionError> {
        let mut definition = Definition::default();
        let mut comment_above: Vec<String> = Vec::new();
        for line in lines {
            let (code, trailing) = match line.split_once('#') {
                Some((code, comment)) => (code.trim(), Some(comment.trim())),
                None => (line.trim(), None),
            };
            if code.is_empty() {
                match trailing {
                    Some(comment) => comment_above.push(comment.to_owned()),
                    None => {
                        let block = std::mem::take(&mut comment_above);
                        let is_first =
                            definition.fields.is_empty() && definition.constants.is_empty();
                        if is_first && definition.comment.is_empty() {
                            definition.comment = block;
                        }
                    }
                }
                continue;
            }
            let mut comment = std::mem::take(&mut comment_above);
            if let (true, Some(trailing)) = (comment.is_empty(), trailing) {
                comment.push(trailing.to_owned());
            }
            let invalid = || DefinitionError::Line(code.to_owned());
            let (type_name, rest) = code.split_once(char::is_whitespace).ok_or_else(invalid)?;
            let r#type = FieldType::parse(package, type_name)?;
            let rest = rest.trim();
            // A default value can contain `=` too, but then more than the name precedes it.
            match rest
                .split_once('=')
                .filter(|(name, _)| !name.trim().contains(char::is_whitespace))
            {
                Some((name, value)) => {
                    let (name, value) = (name.trim().to_owned(), value.trim().to_owned());
                    definition.constants.push(Constant { comment, name, r#type, value });
                }
                None => {
                    let (name, default) = rest.split_once([' ', '\t']).unwrap_or((rest, ""));
                    let (name, default) = (name.to_owned(), default.trim().to_owned());
                    definition.fields.push(Field { comment, name, r#type, default });
                }
            }
        }
        if definition.fields.is_empty() {
            // An IDL struct cannot be empty, so rosidl adds this member.
            definition.fields.push(Field {
                comment: Vec::new(),
                name: "structure_needs_at_least_one_member".to_owned(),
                r#type: FieldType::parse(package, "uint8")?,
                default: String::new(),
            });
        }
        Ok(definition)
    }
}

impl Field {
    /// Returns the default value in Python syntax, which type descriptions use.
    pub fn described_default(&self) -> String {
        match self.r#type.element {
            Element::Primitive(Primitive::Bool) => {
                self.default.replace("true", "True").replace("false", "False")
            }
            Element::Primitive(Primitive::Float32 | Primitive::Float64) => {
                match self.default.parse::<f64>() {
                    Ok(number) => format!("{number:?}"),
                    Err(_) => self.default.clone(),
                }
            }
            _ => self.default.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_fields_constants_and_comments() {
        let text = "# a comment\n\nuint8 LEAST=1 # another\nuint8 MOST = 2\nchar[4] name\n\
                    string<=8[<=2] words\nInner[] inner\nother_msgs/Outer outer\nfloat64 w 1\n\
                    # whether\n# it is on\nbool on true\nint8 x -2";
        let [definition] = &Definition::parse("our_msgs", text).unwrap()[..] else {
            panic!("expected one message");
        };
        assert_eq!(definition.comment, ["a comment"]);
        let constants = definition.constants.iter().map(|c| (c.name.as_str(), c.value.as_str()));
        assert_eq!(constants.collect::<Vec<_>>(), [("LEAST", "1"), ("MOST", "2")]);
        let fields = definition.fields.iter().map(|field| {
            let r#type = &field.r#type;
            let numbers = (r#type.id(), r#type.capacity(), r#type.string_capacity());
            (field.name.as_str(), numbers, r#type.nested_type_name(), field.described_default())
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
        let expected = expected
            .map(|(name, numbers, nested, default)| (name, numbers, nested, default.to_owned()));
        assert_eq!(fields.collect::<Vec<_>>(), expected);
        assert_eq!(definition.constants[0].comment, ["another"]);
        assert_eq!(definition.fields[5].comment, ["whether", "it is on"]);
        assert!(definition.fields[6].comment.is_empty());
    }

    #[test]
    fn a_service_has_two_parts_and_an_empty_part_gets_a_member() {
        let parts = Definition::parse("our_msgs", "---\nbool success").unwrap();
        let [request, response] = &parts[..] else {
            panic!("expected a request and a response");
        };
        assert_eq!(request.fields[0].name, "structure_needs_at_least_one_member");
        assert_eq!(response.fields[0].name, "success");
    }

    #[test]
    fn rejects_an_invalid_size_and_an_incomplete_line() {
        let error = |text| Definition::parse("our_msgs", text).unwrap_err().to_string();
        assert_eq!(
            error("uint8[x] a"),
            "invalid size 'x' in type 'uint8[x]' (expected: a whole number)"
        );
        assert!(error("uint8").starts_with("invalid line 'uint8' (expected: field"));
    }
}
