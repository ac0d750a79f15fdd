//! What the types of some packages look like, as messages.

use rosidl::{Definitions, Described, IndividualDescription};

use crate::{
    DEFINITIONS,
    type_description_interfaces::{
        Field, FieldType, IndividualTypeDescription, TypeDescription, TypeSource,
    },
};

/// The types of the standard packages, and of others; the default knows none.
#[derive(Clone, Debug, Default)]
pub struct Interfaces(Definitions);

impl Interfaces {
    /// The standard packages, and these definitions: full names, such as `my_msgs/msg/Blob`, and
    /// texts, as `DEFINITIONS` of a generated package has them.
    ///
    /// # Errors
    ///
    /// A text is no definition.
    pub fn with(definitions: &[(&str, &str)]) -> Result<Interfaces, rosidl::DefinitionError> {
        let all = DEFINITIONS.iter().chain(definitions);
        Ok(Interfaces(Definitions::new(all.copied())?))
    }

    /// The description of a type by its full name, such as `std_msgs/msg/Header` or
    /// `my_msgs/srv/Move_Request`; none for one that is not known.
    pub fn describe(&self, full_name: &str) -> Option<TypeDescription> {
        let Described { main, referenced, .. } = self.0.describe(full_name)?;
        Some(TypeDescription {
            type_description: individual(main),
            referenced_type_descriptions: referenced.into_iter().map(individual).collect(),
        })
    }

    /// The hash of a type's description (REP-2011).
    pub fn hash(&self, full_name: &str) -> Option<String> {
        Some(self.0.describe(full_name)?.hash())
    }

    /// The definitions of a type and of those that it stands on, in the order of its description.
    /// Those of the standard packages have no comments.
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

fn individual(described: IndividualDescription) -> IndividualTypeDescription {
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
        type_name: described.type_name,
        fields: described.fields.into_iter().map(field).collect(),
    }
}
