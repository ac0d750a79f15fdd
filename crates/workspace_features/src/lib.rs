//! An empty crate whose `Cargo.toml` pins the features of shared dependencies.
