//! Progress on the console: a progress bar on a terminal, otherwise a log line every 50 episodes.

use std::io::{IsTerminal, Write};

use indicatif::{ProgressBar, ProgressStyle};
use log::info;

use learning::{record::Records, training::Training};
use task::EvaluationEpisode;

/// Number of recent training episodes over which the mean return and the success rate are computed;
/// also the number of episodes between log lines.
const RECENT: usize = 50;

/// A progress bar below the log lines.
pub(super) struct Console {
    bar: ProgressBar,
    on_terminal: bool,
}

impl Console {
    /// Creates a progress bar labelled `label` that starts at `finished` of `episodes` episodes.
    /// From then on, the logger prints its lines above the bar.
    pub(super) fn new(label: &'static str, episodes: u32, finished: u32) -> Console {
        let on_terminal = std::io::stderr().is_terminal();
        let bar = match on_terminal {
            true => ProgressBar::new(u64::from(episodes)),
            false => ProgressBar::hidden(),
        };
        // The message is cut off at the edge of the terminal.
        let template = "{prefix} {pos}/{len} {bar:20.green/blue} {elapsed} {wide_msg}";
        let style = ProgressStyle::with_template(template).expect("the template is well-formed");
        bar.set_style(style);
        bar.set_prefix(label);
        bar.set_position(u64::from(finished));
        bar.reset_eta();
        let printer = bar.clone();
        ros_runtime::logging::write_console_through(move |line| {
            printer.suspend(|| write_line(line));
        });
        Console { bar, on_terminal }
    }

    /// Shows the progress of training after an episode.
    pub(super) fn training_episode(&self, training: &Training) {
        let records = &training.progress.records;
        let recent = records.len().clamp(1, RECENT) as f32;
        let returns = records.recent(RECENT).map(|record| record.episode_return);
        let mean_return = returns.sum::<f32>() / recent;
        let facts = format!(
            "{:.0} steps/s  epsilon {:.2}  return {mean_return:.2}  success rate {:.0} %",
            training.steps_per_s(),
            records.iter().next_back().map_or(1.0, |record| record.epsilon),
            100.0 * recent_success(records),
        );
        self.show(records.len() as u64, training.plan.episodes, facts);
    }

    /// Shows the progress of an evaluation after an episode.
    pub(super) fn evaluation_episode(
        &self,
        finished: u32,
        episodes: u32,
        succeeded: u32,
        last: &EvaluationEpisode,
    ) {
        let success_rate = 100.0 * f64::from(succeeded) / f64::from(finished.max(1));
        let facts = format!("success rate {success_rate:.1} %  episode length {}", last.steps);
        self.show(u64::from(finished), episodes, facts);
    }

    fn show(&self, finished: u64, episodes: u32, facts: String) {
        if self.on_terminal {
            self.bar.set_message(facts);
            self.bar.set_position(finished);
        } else if finished.is_multiple_of(RECENT as u64) || finished == u64::from(episodes) {
            info!("{} {finished}/{episodes}: {facts}", self.bar.prefix());
        }
    }
}

impl Drop for Console {
    /// Leaves the bar on the terminal as it is. Later log lines follow below it.
    fn drop(&mut self) {
        self.bar.abandon();
        ros_runtime::logging::write_console_through(write_line);
    }
}

/// Writes a log line. A write error on a closed console must not stop the node.
fn write_line(line: &str) {
    drop(writeln!(std::io::stderr(), "{line}"));
}

/// Returns the success rate, 0 to 1, over the latest 50 training episodes; 0 before the first
/// episode ends.
pub(super) fn recent_success(records: &Records) -> f64 {
    let successes = records.recent(RECENT).filter(|record| record.terminated).count();
    successes as f64 / records.len().clamp(1, RECENT) as f64
}
