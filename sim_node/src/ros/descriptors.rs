//! Descriptors of the node's parameters.

use ros_runtime::parameters::Descriptor;

/// Returns the descriptor of a read-only parameter.
pub(super) fn at_start(description: &str) -> Descriptor {
    Descriptor::read_only(&format!("{description}; read at startup"))
}

/// Returns the descriptor of a parameter that takes effect at the next reset.
pub(super) fn at_next_reset(description: &str) -> Descriptor {
    Descriptor::dynamic(&format!("{description}; takes effect at the next reset"))
}
