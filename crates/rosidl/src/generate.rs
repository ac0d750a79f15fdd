//! Generates Rust types from the definitions in ROS packages, for use in a build script.
//!
//! The message `my_msgs/msg/Blob` becomes the struct `Blob`. The service `my_msgs/srv/SetMode`
//! becomes the marker type `SetMode` and the module `set_mode` with the structs `Request` and
//! `Response`.
//! Each struct has exactly the fields of the definition, in the same order: CDR transmits no field
//! names, so the order of the fields determines the wire format. Comments become documentation, and
//! constants become associated constants.
//!
//! The crate that includes the generated code needs
//!
//! - `serde` with the feature `derive`,
//! - `serde-big-array` if an array has more than 32 elements, and
//! - the traits `Message`, `RosMessage` and `RosService` at the path given to
//!   [`Generator::traits_of`].

use std::{
    collections::BTreeMap,
    fmt::Write,
    fs, io,
    path::{Path, PathBuf},
};

use crate::{
    definition::{Constant, Definition},
    error::GenerateError,
    rust::{self, Types},
};

/// A generator of Rust types for a set of packages.
///
/// # Examples
///
/// In the build script of a crate that includes the result with
/// `include!(concat!(env!("OUT_DIR"), "/interfaces.rs"))`:
///
/// ```no_run
/// use std::{env, path::Path};
///
/// use rosidl::generate::Generator;
///
/// let out = env::var_os("OUT_DIR").expect("Cargo sets OUT_DIR for build scripts");
/// Generator::traits_of("::ros_interfaces")
///     .dependency("std_msgs", Path::new("interfaces/std_msgs"), "::ros_interfaces::std_msgs")?
///     .package("my_msgs", Path::new("."), "crate")?
///     .write(&Path::new(&out).join("interfaces.rs"))?;
/// # Ok::<(), rosidl::GenerateError>(())
/// ```
#[derive(Debug, Default)]
pub struct Generator {
    traits: String,
    files: Vec<File>,
    types: Types,
}

/// A parsed definition file.
#[derive(Debug)]
struct File {
    package: String,
    name: String,
    path: PathBuf,
    parts: Vec<Definition>,
}

impl File {
    fn is_service(&self) -> bool {
        self.path.extension().is_some_and(|extension| extension == "srv")
    }

    fn full_name(&self) -> String {
        let kind = if self.is_service() { "srv" } else { "msg" };
        format!("{}/{kind}/{}", self.package, self.name)
    }
}

impl Generator {
    /// Creates a generator without packages. `traits` is the Rust path of the module that contains
    /// the traits `Message`, `RosMessage` and `RosService`.
    pub fn traits_of(traits: &str) -> Generator {
        Generator { traits: traits.to_owned(), ..Generator::default() }
    }

    /// Adds a package for which to generate types. `directory` contains `msg/`, `srv/` or both, and
    /// `module` is the Rust path of the module that includes the generated code.
    ///
    /// # Errors
    ///
    /// Returns an error if a file cannot be read or is not a valid definition.
    pub fn package(
        mut self,
        name: &str,
        directory: &Path,
        module: &str,
    ) -> Result<Generator, GenerateError> {
        let files = self.read(name, directory, module)?;
        self.files.extend(files);
        Ok(self)
    }

    /// Adds a package whose types already exist at the Rust path `module`, so that fields can use
    /// them.
    ///
    /// # Errors
    ///
    /// Returns an error if a file cannot be read or is not a valid definition.
    pub fn dependency(
        mut self,
        name: &str,
        directory: &Path,
        module: &str,
    ) -> Result<Generator, GenerateError> {
        self.read(name, directory, module)?;
        Ok(self)
    }

    /// Reads a package and registers the Rust paths of its messages.
    fn read(
        &mut self,
        name: &str,
        directory: &Path,
        module: &str,
    ) -> Result<Vec<File>, GenerateError> {
        let files = read_package(name, directory)?;
        for file in files.iter().filter(|file| !file.is_service()) {
            for part in &file.parts {
                let path = format!("{module}::{}", file.name);
                self.types.insert(file.full_name(), path, part.fields.clone());
            }
        }
        Ok(files)
    }

    /// Writes the types of all packages to a file, followed by the constant `DEFINITIONS`, which
    /// holds the full name and the text of every definition. If there are several packages, each
    /// becomes a module.
    ///
    /// # Errors
    ///
    /// Returns an error if the type of a field is undefined or not supported, or if the file cannot
    /// be written.
    pub fn write(&self, path: &Path) -> Result<(), GenerateError> {
        let mut packages: BTreeMap<&str, Vec<&File>> = BTreeMap::new();
        for file in &self.files {
            packages.entry(&file.package).or_default().push(file);
        }
        let mut text = String::new();
        let is_single = packages.len() == 1;
        for (package, files) in &packages {
            let mut types = String::new();
            for file in files {
                types += &self.types_of(file)?;
            }
            match is_single {
                true => text += &types,
                false => {
                    let _ = write!(
                        text,
                        "/// Interfaces of the ROS package `{package}`.\npub mod {package} {{\n{types}}}\n\n"
                    );
                }
            }
        }
        text += "/// The full name and text of every definition.\n";
        text += "pub const DEFINITIONS: &[(&str, &str)] = &[\n";
        for file in packages.values().flatten() {
            let source = fs::canonicalize(&file.path).map_err(|e| file_error(&file.path, e))?;
            let _ = writeln!(text, "    ({:?}, include_str!({source:?})),", file.full_name());
        }
        text += "];\n";
        fs::write(path, text).map_err(|error| file_error(path, error))
    }

    fn types_of(&self, file: &File) -> Result<String, GenerateError> {
        let (full_name, name) = (file.full_name(), &file.name);
        let mut text = String::new();
        if !file.is_service() {
            for part in &file.parts {
                text += &self.structure(&full_name, name, part)?;
                text += &self.message_impl(file);
            }
            return Ok(text);
        }
        let module = rust::identifier(&rust::snake_case(name));
        let traits = &self.traits;
        let _ = write!(
            text,
            "/// The service `{full_name}`.\n\
             #[derive(Clone, Copy, Debug)]\n\
             pub struct {name};\n\n\
             impl {traits}::RosService for {name} {{\n\
             const PACKAGE: &str = {:?};\n\
             const NAME: &str = {name:?};\n\
             type Request = {module}::Request;\n\
             type Response = {module}::Response;\n\
             }}\n\n\
             /// The request and response of [`{name}`].\n\
             pub mod {module} {{\n",
            file.package
        );
        for (role, part) in ["Request", "Response"].into_iter().zip(&file.parts) {
            text += &self.structure(&format!("{full_name}_{role}"), role, part)?;
            let _ = write!(text, "impl {traits}::Message for {role} {{}}\n\n");
        }
        text += "}\n\n";
        Ok(text)
    }

    fn message_impl(&self, file: &File) -> String {
        let (traits, name) = (&self.traits, &file.name);
        format!(
            "impl {traits}::Message for {name} {{}}\n\n\
             impl {traits}::RosMessage for {name} {{\n\
             const PACKAGE: &str = {:?};\n\
             const NAME: &str = {name:?};\n\
             }}\n\n",
            file.package
        )
    }

    /// Returns a struct, its constants and, if `Default` cannot be derived, an `impl Default`.
    fn structure(
        &self,
        full_name: &str,
        name: &str,
        part: &Definition,
    ) -> Result<String, GenerateError> {
        let mut derives = vec!["Clone", "Debug", "PartialEq"];
        let traits = self.types.traits_of(full_name, &part.fields)?;
        derives.extend(traits.is_copy.then_some("Copy"));
        derives.extend(traits.is_eq.then_some("Eq, PartialOrd, Ord, Hash"));
        derives.extend(traits.has_plain_default.then_some("Default"));
        let mut text = format!("/// `{full_name}`.\n");
        if !part.comment.is_empty() {
            text += "///\n";
            text += &documentation(&part.comment);
        }
        let derives = derives.join(", ");
        let _ = write!(
            text,
            "#[derive({derives}, ::serde::Serialize, ::serde::Deserialize)]\npub struct {name} {{\n"
        );
        for field in &part.fields {
            text += &documentation(&field.comment);
            if rust::is_big_array(&field.r#type) {
                text += "#[serde(with = \"::serde_big_array::BigArray\")]\n";
            }
            let (name, r#type) = (rust::identifier(&field.name), self.types.rust(&field.r#type));
            let _ = writeln!(text, "pub {name}: {type},");
        }
        text += "}\n\n";
        if !traits.has_plain_default {
            let _ = write!(text, "impl Default for {name} {{\nfn default() -> Self {{\nSelf {{\n");
            for field in &part.fields {
                let value = rust::default(field).ok_or_else(|| GenerateError::Unsupported {
                    name: full_name.to_owned(),
                    construct: format!("{} = {}", field.name, field.default),
                })?;
                let _ = writeln!(text, "{}: {value},", rust::identifier(&field.name));
            }
            text += "}\n}\n}\n\n";
        }
        if !part.constants.is_empty() {
            let _ = writeln!(text, "impl {name} {{");
            for constant in &part.constants {
                text += &documentation(&constant.comment);
                let Constant { name, r#type, value, .. } = constant;
                let (r#type, value) = rust::constant(r#type, value);
                let _ = writeln!(text, "pub const {name}: {type} = {value};");
            }
            text += "}\n\n";
        }
        Ok(text)
    }
}

/// Returns the lines of a comment as a doc comment.
fn documentation(comment: &[String]) -> String {
    comment.iter().map(|line| format!("/// {line}\n")).collect()
}

/// Reads the definitions of a package: messages first, then services, each sorted by name.
fn read_package(package: &str, directory: &Path) -> Result<Vec<File>, GenerateError> {
    let mut files = Vec::new();
    for kind in ["msg", "srv"] {
        let directory = directory.join(kind);
        let entries = match fs::read_dir(&directory) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
            entries => entries.map_err(|error| file_error(&directory, error))?,
        };
        for entry in entries {
            let path = entry.map_err(|error| file_error(&directory, error))?.path();
            if path.extension().is_none_or(|extension| extension != kind) {
                continue;
            }
            let text = fs::read_to_string(&path).map_err(|error| file_error(&path, error))?;
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let parts = Definition::parse(package, &text).map_err(|source| {
                GenerateError::Definition { name: format!("{package}/{kind}/{name}"), source }
            })?;
            files.push(File { package: package.to_owned(), name, path, parts });
        }
    }
    files.sort_by_key(|file| (file.is_service(), file.name.clone()));
    Ok(files)
}

fn file_error(path: &Path, source: io::Error) -> GenerateError {
    GenerateError::File { path: path.to_owned(), source }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn generated(files: &[(&str, &str)]) -> Result<String, GenerateError> {
        let directory = tempfile::tempdir().unwrap();
        for (path, text) in files {
            let path = directory.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        let output = directory.path().join("interfaces.rs");
        let generator =
            Generator::traits_of("crate").package("our_msgs", directory.path(), "crate")?;
        generator.write(&output)?;
        Ok(fs::read_to_string(output).unwrap())
    }

    #[test]
    fn a_message_becomes_a_struct_with_its_comments_and_constants() {
        let text = generated(&[
            ("msg/Blob.msg", "# A blob.\n\n# None.\nuint8 NONE=0\n# The size, in metres.\nfloat32 size 1\nuint8[] type\n"),
            ("msg/Pair.msg", "Blob[2] blobs\nfloat64[36] covariance\n"),
            ("msg/Id.msg", "char[16] data"),
        ]).unwrap();
        for expected in [
            "/// `our_msgs/msg/Blob`.\n///\n/// A blob.\n#[derive(Clone, Debug, PartialEq, ::serde::",
            "/// The size, in metres.\npub size: f32,\npub r#type: ::std::vec::Vec<u8>,",
            "size: 1.0,\nr#type: ::std::default::Default::default(),",
            "/// None.\npub const NONE: u8 = 0;",
            "pub blobs: [crate::Blob; 2],\n#[serde(with = \"::serde_big_array::BigArray\")]\npub covariance: [f64; 36],",
            "covariance: [::std::default::Default::default(); 36],",
            "#[derive(Clone, Debug, PartialEq, Copy, Eq, PartialOrd, Ord, Hash, Default, ::serde::Serialize",
            "(\"our_msgs/msg/Blob\", include_str!(",
        ] {
            assert!(text.contains(expected), "missing: {expected}\nin: {text}");
        }
    }

    #[test]
    fn keywords_become_valid_identifiers() {
        let text = generated(&[("srv/Move.srv", "bool self\nint32 static\t7\n---\n")]).unwrap();
        for expected in [
            "type Request = r#move::Request;",
            "pub mod r#move {",
            "pub self_: bool,\npub r#static: i32,",
            "r#static: 7,",
        ] {
            assert!(text.contains(expected), "missing: {expected}\nin: {text}");
        }
    }

    #[test]
    fn a_service_becomes_a_marker_type_and_a_module() {
        let text =
            generated(&[("srv/MoveIt.srv", "bool on true\n---\nuint8 OK=0\nstring message\n")])
                .unwrap();
        for expected in [
            "pub struct MoveIt;",
            "type Request = move_it::Request;",
            "pub mod move_it {",
            "on: true,",
            "impl Response {\npub const OK: u8 = 0;",
            "impl crate::Message for Response {}",
        ] {
            assert!(text.contains(expected), "missing: {expected}\nin: {text}");
        }
    }

    #[test]
    fn an_undefined_field_type_is_an_error() {
        let error = generated(&[("msg/A.msg", "std_msgs/Header header")]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "our_msgs/msg/A: field 'header' has the undefined type std_msgs/msg/Header (add its \
             package)"
        );
    }
}
