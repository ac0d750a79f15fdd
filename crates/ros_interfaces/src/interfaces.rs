//! Type descriptions as ROS messages.

use rosidl::{Definitions, Described, IndividualDescription};

use crate::{
    DEFINITIONS,
    type_description_interfaces::{
        Field, FieldType, IndividualTypeDescription, TypeDescription, TypeSource,
    },
};

/// The type descriptions of the standard packages and of additional definitions.
///
/// The default value contains no types.
///
/// # Examples
///
/// ```
/// use ros_interfaces::Interfaces;
///
/// let interfaces = Interfaces::with(&[("my_msgs/msg/Blob", "std_msgs/Header header")])?;
/// let blob = interfaces.describe("my_msgs/msg/Blob").expect("the type is defined");
/// assert_eq!(blob.referenced_type_descriptions.len(), 2); // Header, and Time in Header
/// let hash = interfaces.hash("my_msgs/msg/Blob").expect("the type is defined");
/// assert!(hash.starts_with("RIHS01_"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Interfaces(Definitions);

impl Interfaces {
    /// Returns the type descriptions of the standard packages and of the given definitions.
    ///
    /// Each definition is a pair of a full name, e.g. `my_msgs/msg/Blob`, and the text of the
    /// definition, as in the constant `DEFINITIONS` of a generated package.
    ///
    /// # Errors
    ///
    /// Returns an error if a name or a definition is invalid.
    pub fn with(definitions: &[(&str, &str)]) -> Result<Interfaces, rosidl::DefinitionError> {
        let all = DEFINITIONS.iter().chain(definitions);
        Ok(Interfaces(Definitions::new(all.copied())?))
    }

    /// Returns the description of a type by its full name, e.g. `std_msgs/msg/Header` or
    /// `my_msgs/srv/Move_Request`.
    ///
    /// Returns `None` if the type, or a type that it references, is unknown.
    pub fn describe(&self, full_name: &str) -> Option<TypeDescription> {
        let Described { main, referenced, .. } = self.0.describe(full_name)?;
        Some(TypeDescription {
            type_description: individual(main),
            referenced_type_descriptions: referenced.into_iter().map(individual).collect(),
        })
    }

    /// Returns the type hash (REP-2011), or `None` if the type is unknown.
    pub fn hash(&self, full_name: &str) -> Option<String> {
        Some(self.0.describe(full_name)?.hash())
    }

    /// Returns the definitions of a type and of all types that it references, in the same order as
    /// in its description, or an empty vector if the type is unknown.
    ///
    /// The definitions of the standard packages contain no comments.
    pub fn sources(&self, full_name: &str) -> Vec<TypeSource> {
        let sources = self.0.describe(full_name).map(|described| described.sources);
        let source = |source: rosidl::Source| TypeSource {
            type_name: source.type_name,
            encoding: source.encoding.name().to_owned(),
            raw_file_contents: source.text.trim_end().to_owned(),
        };
        sources.unwrap_or_default().into_iter().map(source).collect()
    }
}

fn individual(description: IndividualDescription) -> IndividualTypeDescription {
    let field = |field: rosidl::Field| Field {
        default_value: field.described_default(),
        r#type: FieldType {
            type_id: field.r#type.id(),
            capacity: field.r#type.capacity(),
            string_capacity: field.r#type.string_capacity(),
            nested_type_name: field.r#type.nested_type_name().to_owned(),
        },
        name: field.name,
    };
    IndividualTypeDescription {
        type_name: description.type_name,
        fields: description.fields.into_iter().map(field).collect(),
    }
}
