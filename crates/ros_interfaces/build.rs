//! Generates the Rust types from the definitions in `interfaces`.

use std::{env, error::Error, fs, path::Path};

use rosidl::generate::Generator;

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=interfaces");
    let mut generator = Generator::traits_of("crate");
    for entry in fs::read_dir("interfaces")? {
        let directory = entry?.path();
        if let Some(package) = directory.file_name().filter(|_| directory.is_dir()) {
            let package = package.to_string_lossy();
            generator = generator.package(&package, &directory, &format!("crate::{package}"))?;
        }
    }
    let out = env::var_os("OUT_DIR").ok_or("OUT_DIR is not set")?;
    Ok(generator.write(&Path::new(&out).join("interfaces.rs"))?)
}
