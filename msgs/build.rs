//! Generates the Rust types from the definitions in `msg` and `srv`.

use std::{env, error::Error, path::Path};

use rosidl::generate::Generator;

/// The packages that the definitions depend on.
const DEPENDENCIES: [&str; 3] = ["builtin_interfaces", "sensor_msgs", "std_msgs"];

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=msg");
    println!("cargo::rerun-if-changed=srv");
    println!("cargo::rerun-if-changed=../crates/ros_interfaces/interfaces");
    let standard = Path::new("../crates/ros_interfaces/interfaces");
    let mut generator = Generator::traits_of("::ros_interfaces");
    for package in DEPENDENCIES {
        let directory = standard.join(package);
        let module = format!("::ros_interfaces::{package}");
        generator = generator.dependency(package, &directory, &module)?;
    }
    let generator = generator.package("evac_msgs", Path::new("."), "crate")?;
    let out = env::var_os("OUT_DIR").ok_or("OUT_DIR is not set")?;
    Ok(generator.write(&Path::new(&out).join("interfaces.rs"))?)
}
