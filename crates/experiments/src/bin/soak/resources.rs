//! The resource usage of the nodes.

/// The resource usage of a node.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct ResourceUsage {
    /// Resident memory, in MB (10^6 bytes).
    pub memory_mb: f64,
    /// Number of open file descriptors.
    pub handles: usize,
}

/// The resource usage of both nodes at one point during training.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Sample {
    /// Steps that the simulator has executed so far.
    pub steps: u64,
    /// Resource usage of `sim_node`.
    pub sim: ResourceUsage,
    /// Resource usage of `agent_node`.
    pub agent: ResourceUsage,
}
