//! Formats the measurements as a text table and as JSON.

use std::fmt::Write;

use serde_json::{Value, json};
use task::Scenario;

use crate::{
    learner::LearnerFigures,
    peers::PeerFigures,
    room::RoomFigures,
    round_trip::{Percentiles, RoundTripFigures},
    scale::{MOTION_TIME_S, SUCCESS_STEPS, ScaleFigures},
    start_up::StartUpFigures,
    training::TrainingFigures,
};

/// The measurements of one run.
pub struct Report {
    pub room: Vec<RoomFigures>,
    pub learner: Vec<LearnerFigures>,
    pub round_trip: RoundTripFigures,
    pub start_up: StartUpFigures,
    pub training: TrainingFigures,
    /// Training runs in ascending order of the number of simulators; empty without `--scale`.
    pub scale: Vec<ScaleFigures>,
    pub peers: PeerFigures,
}

impl Report {
    /// Returns the table, with one row per measurement: name, value, comparison with a baseline.
    pub fn table(&self) -> String {
        let mut rows: Vec<[String; 3]> = Vec::new();
        let mut row = |name: &str, value: String, comparison: String| {
            rows.push([name.to_owned(), value, comparison]);
        };
        let ratio =
            |value: f64, baseline: f64, name: &str| format!("{:.2} x {name}", value / baseline);
        for figures in &self.learner {
            let preset = figures.preset;
            row("sgemm", format!("{:.1} GFLOP/s", figures.sgemm_gflops), "baseline".into());
            let mut comparison = ratio(
                figures.update_us,
                figures.update_roofline_us,
                &format!("the sgemm roofline ({:.0} us)", figures.update_roofline_us),
            );
            if let Some(torch) = self.peers.torch_update_us(preset) {
                let times = torch / figures.update_us;
                write!(comparison, "; PyTorch {torch:.0} us, {times:.1} x").ok();
            }
            row(&format!("update, {preset}"), format!("{:.1} us", figures.update_us), comparison);
            row(
                &format!("inference, {preset}"),
                format!("{:.2} us", figures.inference_us),
                String::new(),
            );
        }
        let RoundTripFigures { udp, plain, step } = &self.round_trip;
        let times = |times: &Percentiles| {
            format!("{:.0} / {:.0} / {:.0} us", times.p50, times.p99, times.p999)
        };
        row("bare UDP round trip, p50 / p99 / p99.9", times(udp), "baseline".into());
        row("plain ros2-client service", times(plain), "baseline".into());
        let comparison = ratio(step.p50, plain.p50, "plain service")
            + &format!("; p99.9 is {:.1} x p50", step.p999 / step.p50);
        row("sim_node step", times(step), comparison);
        if let Some(cyclone) = self.peers.cyclone_rtt_us {
            row("CycloneDDS from Python", format!("{cyclone:.0} us"), "reference".into());
        }
        if let Some(ddsperf) = self.peers.ddsperf_rtt_us {
            row("CycloneDDS's ddsperf", format!("{ddsperf:.0} us"), "reference".into());
        }
        let StartUpFigures { publisher_later_s, subscriber_later_s } = self.start_up;
        row(
            "time from sim_node start to first image",
            format!("{publisher_later_s:.2} s"),
            format!("{subscriber_later_s:.2} s from the start of a late-joining subscriber"),
        );
        let training = &self.training;
        let (wall_ratio, updates_s) = (training.wall_ratio(), training.updates_s());
        row(
            &format!("training over DDS, {} steps", training.steps),
            format!("{:.1} s", training.wall_s),
            format!("{wall_ratio:.2} x the total update time ({updates_s:.1} s)"),
        );
        let steps_per_s = training.over_dds_steps_per_s;
        let comparison = self.peers.sb3_steps_per_s.map_or_else(String::new, |sb3| {
            format!("{:.1} x Stable-Baselines3 ({sb3:.0} steps/s)", steps_per_s / sb3)
        });
        row("training over DDS", format!("{steps_per_s:.0} steps/s"), comparison);
        row(
            "training in one process",
            format!("{:.0} steps/s", training.in_process_steps_per_s),
            String::new(),
        );
        for figures in &self.scale {
            let success =
                figures.success_s.map_or("not reached".to_owned(), |s| format!("after {s:.0} s"));
            row(
                &format!("{} simulators, {MOTION_TIME_S} s per move", figures.rooms),
                format!("{:.0} steps/s", figures.steps_per_s),
                format!(
                    "{:.0} s in total; 90 % of episodes within {SUCCESS_STEPS} steps: {success}",
                    figures.wall_s
                ),
            );
        }
        for figures in &self.room {
            row(
                &format!("simulator, {}", figures.scenario),
                format!("{:.0} steps/s", figures.steps_per_s),
                String::new(),
            );
        }
        row(
            "resident memory, sim_node and agent_node",
            format!("{:.1} and {:.1} MB", training.sim_rss_mb, training.agent_rss_mb),
            String::new(),
        );
        let width =
            |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
        let (first, second) = (width(0), width(1));
        rows.iter()
            .map(|[name, value, comparison]| {
                let line = format!("{name:first$}  {value:>second$}  {comparison}");
                line.trim_end().to_owned() + "\n"
            })
            .collect()
    }

    /// Returns the measurements as JSON. The keys are a stable interface.
    pub fn json(&self) -> serde_json::Result<String> {
        let percentiles = |p: &Percentiles| json!({"p50": p.p50, "p99": p.p99, "p999": p.p999});
        let steps_per_s = |scenario: Scenario| -> Value {
            let figures = self.room.iter().find(|figures| figures.scenario == scenario);
            figures.map_or(Value::Null, |figures| figures.steps_per_s.into())
        };
        let presets: serde_json::Map<String, Value> = self
            .learner
            .iter()
            .map(|figures| {
                let value = json!({
                    "update_us": figures.update_us,
                    "update_roofline_us": figures.update_roofline_us,
                    "inference_us": figures.inference_us,
                    "sgemm_gflops": figures.sgemm_gflops,
                    "torch_update_us": self.peers.torch_update_us(figures.preset),
                });
                (figures.preset.to_string(), value)
            })
            .collect();
        let scenarios: serde_json::Map<String, Value> = self
            .room
            .iter()
            .map(|figures| (figures.scenario.to_string(), figures.steps_per_s.into()))
            .collect();
        let scale: Vec<Value> = self
            .scale
            .iter()
            .map(|figures| {
                json!({
                    "simulators": figures.rooms,
                    "steps": figures.steps,
                    "wall_s": figures.wall_s,
                    "steps_per_s": figures.steps_per_s,
                    "success_s": figures.success_s,
                })
            })
            .collect();
        let paper = &presets["paper"];
        let figures = json!({
            "sgemm_gflops": paper["sgemm_gflops"],
            "udp_rtt_us": self.round_trip.udp.p50,
            "plain_client_rtt_us": self.round_trip.plain.p50,
            "ddsperf_rtt_us": self.peers.ddsperf_rtt_us,
            "cyclone_rtt_us": self.peers.cyclone_rtt_us,
            "update_us": paper["update_us"],
            "update_roofline_us": paper["update_roofline_us"],
            "torch_update_us": paper["torch_update_us"],
            "sb3_steps_per_s": self.peers.sb3_steps_per_s,
            "inference_us": paper["inference_us"],
            "step_rtt_us": percentiles(&self.round_trip.step),
            "plain_client_rtt_percentiles_us": percentiles(&self.round_trip.plain),
            "start_up_s": {
                "publisher_later": self.start_up.publisher_later_s,
                "subscriber_later": self.start_up.subscriber_later_s,
            },
            "steps_per_s_over_dds": self.training.over_dds_steps_per_s,
            "steps_per_s_in_process": self.training.in_process_steps_per_s,
            "training_steps": self.training.steps,
            "training_wall_s": self.training.wall_s,
            "training_update_us": self.training.update_us,
            "sim_steps_per_s": steps_per_s(Scenario::ThreeCylinders),
            "sim_steps_per_s_by_scenario": scenarios,
            "rss_mb": {"sim": self.training.sim_rss_mb, "agent": self.training.agent_rss_mb},
            "simulators": scale,
            "presets": presets,
        });
        serde_json::to_string_pretty(&figures).map(|text| text + "\n")
    }
}
