//! Messages and the service of the ROS package `type_description_interfaces`: what a type looks like.

mod field;
mod field_type;
pub mod get_type_description;
mod individual_type_description;
mod key_value;
mod type_description;
mod type_source;

pub use field::Field;
pub use field_type::FieldType;
pub use get_type_description::GetTypeDescription;
pub use individual_type_description::IndividualTypeDescription;
pub use key_value::KeyValue;
pub use type_description::TypeDescription;
pub use type_source::TypeSource;

/// The name of the ROS package.
const PACKAGE: &str = "type_description_interfaces";
