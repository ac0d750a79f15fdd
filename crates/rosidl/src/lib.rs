//! ROS interface definitions: the language of `.msg` and `.srv` files
//! (<https://docs.ros.org/en/jazzy/Concepts/Basic/About-Interfaces.html>).
//!
//! - [`definition`]: reads a file: its fields, constants and comments.
//! - [`description`]: what a type looks like to other nodes, and the hash that tells it from others of
//!   its name (REP-2011, REP-2016).
//! - [`generate`]: writes the types of a package as Rust, for a build script.
//!
//! ```
//! use rosidl::{Definition, Definitions};
//!
//! let text = "std_msgs/Header header\nuint8[] data";
//! let message = &Definition::parse("my_msgs", text)?[0];
//! assert_eq!(message.fields[1].name, "data");
//!
//! let definitions = Definitions::new([("my_msgs/msg/Blob", "uint8[] data")])?;
//! let described = definitions.describe("my_msgs/msg/Blob").expect("it was just defined");
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
