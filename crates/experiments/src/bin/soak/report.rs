//! The result of a soak test, as a text table and as JSON.

use std::{fmt::Write, time::Duration};

use anyhow::ensure;
use experiments::network::Traffic;
use serde_json::json;

use crate::resources::{ResourceUsage, Sample};

/// Maximum memory of a node at the end, relative to its memory after `SETTLED_STEPS`.
const MAX_GROWTH: f64 = 1.05;

/// The measurements of a soak test.
pub struct Report {
    /// Steps that the agent has learned from.
    pub steps: u64,
    /// Steps that the simulator has executed.
    pub executed: u64,
    /// Whether the episodes and weights equal those of the same training run without a network.
    pub is_as_undisturbed: bool,
    pub traffic: Traffic,
    /// Number of network cuts.
    pub cuts: u64,
    /// The longest time that the agent waited for a step.
    pub longest_latency: Duration,
    /// Wall time of the training run.
    pub took: Duration,
    /// Resource usage after `SETTLED_STEPS`.
    pub first: Sample,
    /// Resource usage at the end.
    pub last: Sample,
    /// Resource usage at intervals of at least `SAMPLE_STEPS`, starting with `first`.
    pub samples: Vec<Sample>,
}

impl Report {
    /// Returns the number of steps that the agent learned from but the simulator did not execute. A
    /// lost and a duplicated step would cancel out here, but they would change the training result.
    fn lost(&self) -> u64 {
        self.steps.saturating_sub(self.executed)
    }

    /// Returns the number of steps that the simulator executed more than once.
    fn duplicated(&self) -> u64 {
        self.executed.saturating_sub(self.steps)
    }

    fn nodes(&self) -> [(&'static str, ResourceUsage, ResourceUsage); 2] {
        let Report { first, last, .. } = self;
        [("sim_node", first.sim, last.sim), ("agent_node", first.agent, last.agent)]
    }

    /// Returns the table, with one row per measurement.
    pub fn table(&self) -> String {
        let Report { traffic, .. } = self;
        let share = |frames: u64| {
            format!("{frames} ({:.1} %)", 100.0 * frames as f64 / traffic.frames.max(1) as f64)
        };
        let mut rows = vec![
            ("training steps", self.steps.to_string()),
            ("steps lost", self.lost().to_string()),
            ("steps duplicated", self.duplicated().to_string()),
            (
                "result, compared with the undisturbed training run",
                if self.is_as_undisturbed { "bit-identical" } else { "DIFFERENT" }.to_owned(),
            ),
            ("wall time", format!("{:.0} s", self.took.as_secs_f64())),
            ("frames sent", traffic.frames.to_string()),
            ("frames lost", share(traffic.lost)),
            ("frames duplicated", share(traffic.repeated)),
            ("network cuts", self.cuts.to_string()),
            ("longest step latency", format!("{:.2} s", self.longest_latency.as_secs_f64())),
        ];
        let mut node_rows = Vec::new();
        for (node, first, last) in self.nodes() {
            node_rows.push((
                format!("{node}: memory after {} steps and at the end", self.first.steps),
                format!("{:.1}, {:.1} MB", first.memory_mb, last.memory_mb),
            ));
            node_rows.push((
                format!("{node}: open files after {} steps and at the end", self.first.steps),
                format!("{}, {}", first.handles, last.handles),
            ));
        }
        rows.extend(node_rows.iter().map(|(name, value)| (name.as_str(), value.clone())));
        let mut table = String::new();
        for (name, value) in rows {
            writeln!(table, "{name:58} {value:>28}").expect("writing to a String cannot fail");
        }
        table
    }

    /// Returns the measurements as JSON.
    pub fn json(&self) -> anyhow::Result<String> {
        let Report { traffic, .. } = self;
        Ok(serde_json::to_string_pretty(&json!({
            "steps": self.steps,
            "executed": self.executed,
            "lost": self.lost(),
            "repeated": self.duplicated(),
            "is_as_undisturbed": self.is_as_undisturbed,
            "seconds": self.took.as_secs_f64(),
            "frames": { "sent": traffic.frames, "lost": traffic.lost, "repeated": traffic.repeated },
            "cuts": self.cuts,
            "longest_latency_s": self.longest_latency.as_secs_f64(),
            "settled": self.first,
            "end": self.last,
            "samples": self.samples,
        }))?)
    }

    /// Checks that no step was lost or duplicated, that the result equals that of the undisturbed
    /// training run, that neither node's memory has grown beyond `MAX_GROWTH`, and that neither
    /// node's number of open files has grown.
    ///
    /// # Errors
    ///
    /// Returns an error that names the first condition that does not hold.
    pub fn check(&self) -> anyhow::Result<()> {
        let Report { steps, executed, .. } = self;
        ensure!(steps == executed, "sim_node executed {executed} steps (expected: {steps})");
        ensure!(
            self.is_as_undisturbed,
            "the result differs from that of the undisturbed training run"
        );
        for (node, first, last) in self.nodes() {
            let (before, after) = (first.memory_mb, last.memory_mb);
            let is_stable = after <= MAX_GROWTH * before;
            ensure!(is_stable, "memory of {node} has grown from {before:.1} to {after:.1} MB");
            let (before, after) = (first.handles, last.handles);
            ensure!(after <= before, "open files of {node} have grown from {before} to {after}");
        }
        Ok(())
    }
}
