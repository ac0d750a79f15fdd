//! ROS interface definitions: `.msg` and `.srv` files
//! (<https://docs.ros.org/en/jazzy/Concepts/Basic/About-Interfaces.html>).
//!
//! - [`definition`]: parses the fields, constants and comments of a file.
//! - [`description`]: computes type descriptions and type hashes (REP-2011, REP-2016).
//! - [`generate`]: generates the Rust types of a package in a build script.
//!
//! # Examples
//!
//! ```
//! use rosidl::{Definition, Definitions};
//!
//! let text = "std_msgs/Header header\nuint8[] data";
//! let message = &Definition::parse("my_msgs", text)?[0];
//! assert_eq!(message.fields[1].name, "data");
//!
//! let definitions = Definitions::new([("my_msgs/msg/Blob", "uint8[] data")])?;
//! let described = definitions.describe("my_msgs/msg/Blob").expect("the type is defined");
//! assert!(described.hash().starts_with("RIHS01_"));
//! # Ok::<(), rosidl::DefinitionError>(())
//! ```

pub mod definition;
pub mod description;
mod error;
mod field_type;
pub mod generate;
mod rust;

pub use definition::{Constant, Definition, Field};
pub use description::{Definitions, Described, IndividualDescription, Source, SourceEncoding};
pub use error::{DefinitionError, GenerateError};
pub use field_type::{Element, FieldType, Primitive, Repetition};
