//! What a definition says.

use crate::{
    error::DefinitionError,
    field_type::{Element, FieldType, Primitive},
};

/// What a definition says of a message, or of one half of a service.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Definition {
    /// The comment at its top, which an empty line follows.
    pub comment: Vec<String>,
    /// The constants, in their order.
    pub constants: Vec<Constant>,
    /// The fields, in their order.
    pub fields: Vec<Field>,
}

/// A constant.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// The comment above it, or else the one behind it.
    pub comment: Vec<String>,
    /// Its name.
    pub name: String,
    /// Its type.
    pub r#type: FieldType,
    /// Its value, as it is written.
    pub value: String,
}

/// A field.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// The comment above it, or else the one behind it.
    pub comment: Vec<String>,
    /// Its name.
    pub name: String,
    /// Its type.
    pub r#type: FieldType,
    /// Its default value as it is written, or empty.
    pub default: String,
}

impl Definition {
    /// Reads a definition of a package: one of a message, the request and the response of a service.
    ///
    /// # Errors
    ///
    /// A line is no part of the language.
    pub fn parse(package: &str, text: &str) -> Result<Vec<Definition>, DefinitionError> {
        let lines: Vec<&str> = text.lines().collect();
        let parts = lines.split(|line| line.trim_end() == "---");
        parts.map(|lines| Definition::of_lines(package, lines)).collect()
    }

    fn of_lines(package: &str, lines: &[&str]) -> Result<Definition, DefinitionError> {
        let mut definition = Definition::default();
        let mut comment: Vec<String> = Vec::new();
        for line in lines {
            let (said, remark) = line.split_once('#').map_or((*line, None), |(s, r)| (s, Some(r)));
            let said = said.trim();
            if said.is_empty() {
                match remark {
                    Some(remark) => comment.push(remark.trim().to_owned()),
                    None => {
                        let about = std::mem::take(&mut comment);
                        let is_first =
                            definition.fields.is_empty() && definition.constants.is_empty();
                        if is_first && definition.comment.is_empty() {
                            definition.comment = about;
                        }
                    }
                }
                continue;
            }
            let mut comment = std::mem::take(&mut comment);
            if let (true, Some(remark)) = (comment.is_empty(), remark) {
                comment.push(remark.trim().to_owned());
            }
            let wrong = || DefinitionError::Line(said.to_owned());
            let (written, rest) = said.split_once(char::is_whitespace).ok_or_else(wrong)?;
            let r#type = FieldType::parse(package, written)?;
            let rest = rest.trim();
            match rest
                .split_once('=')
                .filter(|(name, _)| !name.trim().contains(char::is_whitespace))
            {
                Some((name, value)) => {
                    let (name, value) = (name.trim().to_owned(), value.trim().to_owned());
                    definition.constants.push(Constant { comment, name, r#type, value });
                }
                None => {
                    let (name, default) = rest.split_once(' ').unwrap_or((rest, ""));
                    let (name, default) = (name.to_owned(), default.trim().to_owned());
                    definition.fields.push(Field { comment, name, r#type, default });
                }
            }
        }
        if definition.fields.is_empty() {
            // A struct of IDL cannot be empty, so rosidl puts this into it.
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
    /// The default value as a description has it: as Python writes it.
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
    fn what_a_line_may_say() {
        let text = "# a comment\n\nuint8 LEAST=1 # another\nuint8 MOST = 2\nchar[4] name\n\
                    string<=8[<=2] words\nInner[] inner\nother_msgs/Outer outer\nfloat64 w 1\n\
                    # whether\n# it is on\nbool on true\nint8 x -2";
        let [definition] = &Definition::parse("our_msgs", text).unwrap()[..] else {
            panic!("one message");
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
    fn a_service_has_two_halves_and_an_empty_one_has_a_member() {
        let halves = Definition::parse("our_msgs", "---\nbool success").unwrap();
        let [request, response] = &halves[..] else {
            panic!("a request and a response");
        };
        assert_eq!(request.fields[0].name, "structure_needs_at_least_one_member");
        assert_eq!(response.fields[0].name, "success");
    }

    #[test]
    fn what_is_wrong_is_said() {
        let error = |text| Definition::parse("our_msgs", text).unwrap_err().to_string();
        assert_eq!(error("uint8[x] a"), "'uint8[x]' has the size 'x': expected a whole number");
        assert!(error("uint8").starts_with("'uint8' is neither a field"));
    }
}
