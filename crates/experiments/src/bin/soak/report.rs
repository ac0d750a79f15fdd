//! What a soak has shown, as a table for people and as JSON for programs.

use std::{fmt::Write, time::Duration};

use anyhow::ensure;
use experiments::network::Traffic;
use serde_json::json;

use crate::{Holdings, Sample};

/// By how much a node's memory may grow once it has all that it needs.
const GROWTH: f64 = 1.05;

/// Everything that was seen.
pub struct Report {
    /// Steps that the agent has learnt from.
    pub steps: u64,
    /// Steps that the simulator has executed.
    pub executed: u64,
    /// Whether episodes and weights are those of the same training without a network.
    pub is_as_undisturbed: bool,
    pub traffic: Traffic,
    /// How often the network was cut off.
    pub cuts: u64,
    pub longest_latency: Duration,
    pub took: Duration,
    /// What the nodes held once they had settled, and at the end.
    pub first: Sample,
    pub last: Sample,
    /// What they held in between, from the first on.
    pub samples: Vec<Sample>,
}

impl Report {
    /// One that is lost and one that is repeated are none here, but another result.
    fn lost(&self) -> u64 {
        self.steps.saturating_sub(self.executed)
    }

    fn repeated(&self) -> u64 {
        self.executed.saturating_sub(self.steps)
    }

    fn nodes(&self) -> [(&'static str, Holdings, Holdings); 2] {
        let Report { first, last, .. } = self;
        [("sim_node", first.sim, last.sim), ("agent_node", first.agent, last.agent)]
    }

    /// A row a figure.
    pub fn table(&self) -> String {
        let Report { traffic, .. } = self;
        let share = |frames: u64| {
            format!("{frames} ({:.1} %)", 100.0 * frames as f64 / traffic.frames.max(1) as f64)
        };
        let mut rows = vec![
            ("steps learnt from", self.steps.to_string()),
            ("steps lost", self.lost().to_string()),
            ("steps repeated", self.repeated().to_string()),
            (
                "result",
                if self.is_as_undisturbed { "as undisturbed, to the bit" } else { "DIFFERENT" }
                    .to_owned(),
            ),
            ("time", format!("{:.0} s", self.took.as_secs_f64())),
            ("frames sent", traffic.frames.to_string()),
            ("frames lost", share(traffic.lost)),
            ("frames repeated", share(traffic.repeated)),
            ("cuts of the network", self.cuts.to_string()),
            ("longest wait for a step", format!("{:.2} s", self.longest_latency.as_secs_f64())),
        ];
        let mut names = Vec::new();
        for (node, first, last) in self.nodes() {
            names.push((
                format!("{node}: memory after {} steps, at the end", self.first.steps),
                format!("{:.1}, {:.1} MB", first.memory_mb, last.memory_mb),
            ));
            names.push((
                format!("{node}: handles after {} steps, at the end", self.first.steps),
                format!("{}, {}", first.handles, last.handles),
            ));
        }
        rows.extend(names.iter().map(|(name, value)| (name.as_str(), value.clone())));
        let mut table = String::new();
        for (name, value) in rows {
            writeln!(table, "{name:58} {value:>28}").expect("a text takes all");
        }
        table
    }

    /// The same for programs.
    pub fn json(&self) -> anyhow::Result<String> {
        let Report { traffic, .. } = self;
        Ok(serde_json::to_string_pretty(&json!({
            "steps": self.steps,
            "executed": self.executed,
            "lost": self.lost(),
            "repeated": self.repeated(),
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

    /// Fails unless every promise was kept.
    pub fn check(&self) -> anyhow::Result<()> {
        let Report { steps, executed, .. } = self;
        ensure!(steps == executed, "{executed} steps were executed, and {steps} were asked for");
        ensure!(self.is_as_undisturbed, "the result is not that of the undisturbed training");
        for (node, first, last) in self.nodes() {
            let (before, after) = (first.memory_mb, last.memory_mb);
            ensure!(after <= GROWTH * before, "{node} has grown from {before:.1} to {after:.1} MB");
            let (before, after) = (first.handles, last.handles);
            ensure!(after <= before, "{node} had {before} handles, and has {after} at the end");
        }
        Ok(())
    }
}
