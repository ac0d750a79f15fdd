//! The figures as a table for people and as JSON for programs.

use std::fmt::Write;

use serde_json::{Value, json};
use task::Scenario;

use crate::{
    learner::LearnerFigures,
    peers::PeerFigures,
    room::RoomFigures,
    round_trip::{Percentiles, RoundTripFigures},
    scale::{MOTION_TIME_S, ScaleFigures},
    start_up::StartUpFigures,
    training::TrainingFigures,
};

/// Everything that was measured.
pub struct Report {
    pub room: Vec<RoomFigures>,
    pub learner: Vec<LearnerFigures>,
    pub round_trip: RoundTripFigures,
    pub start_up: StartUpFigures,
    pub training: TrainingFigures,
    /// Trainings in rooms that take their time, by how many of them there are.
    pub scale: Vec<ScaleFigures>,
    pub peers: PeerFigures,
}

impl Report {
    /// A row a figure: what, how much, and beside which ruler.
    pub fn table(&self) -> String {
        let mut rows: Vec<[String; 3]> = Vec::new();
        let mut row = |what: &str, value: String, beside: String| {
            rows.push([what.to_owned(), value, beside]);
        };
        let ratio = |value: f64, ruler: f64, name: &str| format!("{:.2} x {name}", value / ruler);
        for figures in &self.learner {
            let preset = figures.preset;
            row("sgemm", format!("{:.1} GFLOP/s", figures.sgemm_gflops), "the ruler".into());
            let mut beside = ratio(
                figures.update_us,
                figures.update_roofline_us,
                &format!("its {:.0} us of sgemm", figures.update_roofline_us),
            );
            if let Some(torch) = self.peers.torch_update_us(preset) {
                write!(beside, "; PyTorch {torch:.0} us, {:.1} x", torch / figures.update_us).ok();
            }
            row(&format!("update, {preset}"), format!("{:.1} us", figures.update_us), beside);
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
        row("bare UDP round trip, p50 / p99 / p99.9", times(udp), "the ruler".into());
        row("plain ros2-client service", times(plain), "the ruler".into());
        let beside = ratio(step.p50, plain.p50, "plain")
            + &format!("; p99.9 is {:.1} x p50", step.p999 / step.p50);
        row("step of sim_node", times(step), beside);
        if let Some(cyclone) = self.peers.cyclone_rtt_us {
            row("CycloneDDS from Python", format!("{cyclone:.0} us"), "a peer".into());
        }
        if let Some(ddsperf) = self.peers.ddsperf_rtt_us {
            row("CycloneDDS's ddsperf", format!("{ddsperf:.0} us"), "a peer".into());
        }
        let StartUpFigures { publisher_later_s, subscriber_later_s } = self.start_up;
        row(
            "start of sim_node to its first image elsewhere",
            format!("{publisher_later_s:.2} s"),
            format!("{subscriber_later_s:.2} s where the subscriber starts later"),
        );
        let training = &self.training;
        row(
            &format!("training over DDS, {} steps", training.steps),
            format!("{:.1} s", training.wall_s),
            format!("{:.2} x its {:.1} s of updates", training.wall_ratio(), training.updates_s()),
        );
        let mut beside = String::new();
        if let Some(sb3) = self.peers.sb3_steps_per_s {
            beside = format!(
                "{:.1} x Stable-Baselines3's {sb3:.0}",
                training.over_dds_steps_per_s / sb3
            );
        }
        row("training over DDS", format!("{:.0} steps/s", training.over_dds_steps_per_s), beside);
        row(
            "training in one process",
            format!("{:.0} steps/s", training.in_process_steps_per_s),
            String::new(),
        );
        for figures in &self.scale {
            let success = figures.success_s.map_or("never".to_owned(), |s| format!("{s:.0} s"));
            row(
                &format!("{} rooms, {MOTION_TIME_S} s a move", figures.rooms),
                format!("{:.0} steps/s", figures.steps_per_s),
                format!("{:.0} s in all, {success} until 9 of 10 escape soon", figures.wall_s),
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
            .map(|[what, value, beside]| {
                let line = format!("{what:first$}  {value:>second$}  {beside}");
                line.trim_end().to_owned() + "\n"
            })
            .collect()
    }

    /// The figures under stable names.
    pub fn json(&self) -> serde_json::Result<String> {
        let percentiles = |p: &Percentiles| json!({"p50": p.p50, "p99": p.p99, "p999": p.p999});
        let steps_per_s = |wanted: Scenario| -> Value {
            let found = self.room.iter().find(|figures| figures.scenario == wanted);
            found.map_or(Value::Null, |figures| figures.steps_per_s.into())
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
