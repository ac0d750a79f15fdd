//! How far a run is, on the console: a bar on a terminal, a line per 50 episodes elsewhere.

use std::io::{IsTerminal, Write};

use indicatif::{ProgressBar, ProgressStyle};
use log::info;

use learning::{record::Records, training::Training};
use task::TestEpisode;

/// How many episodes "recent" are.
const RECENT: usize = 50;

/// A progress bar that log lines step aside for.
pub(super) struct Console {
    bar: ProgressBar,
    on_terminal: bool,
}

impl Console {
    pub(super) fn new(what: &'static str, episodes: u32, done: u32) -> Console {
        let on_terminal = std::io::stderr().is_terminal();
        let bar = match on_terminal {
            true => ProgressBar::new(u64::from(episodes)),
            false => ProgressBar::hidden(),
        };
        let template = "{prefix} {pos}/{len} {bar:30.green/blue} {elapsed} (left {eta})  {msg}";
        let style = ProgressStyle::with_template(template).expect("the template is well-formed");
        bar.set_style(style);
        bar.set_prefix(what);
        bar.set_position(u64::from(done));
        bar.reset_eta();
        let printer = bar.clone();
        ros_runtime::logging::write_console_through(move |line| {
            // A closed console is no reason to stop.
            printer.suspend(|| drop(writeln!(std::io::stderr(), "{line}")));
        });
        Console { bar, on_terminal }
    }

    pub(super) fn training_episode(&self, training: &Training) {
        let records = &training.progress.records;
        let recent = records.len().clamp(1, RECENT) as f32;
        let returns = records.recent(RECENT).map(|record| record.episode_return);
        let mean_return = returns.sum::<f32>() / recent;
        let facts = format!(
            "{:.0} steps/s  epsilon {:.2}  return {mean_return:.2}  success {:.0} %",
            training.steps_per_s(),
            records.iter().next_back().map_or(1.0, |record| record.epsilon),
            100.0 * recent_success(records),
        );
        self.show(records.len() as u64, training.plan.episodes, facts);
    }

    pub(super) fn test_episode(&self, done: u32, episodes: u32, escaped: u32, last: &TestEpisode) {
        let share = 100.0 * f64::from(escaped) / f64::from(done.max(1));
        let facts = format!("success {share:.1} %  last episode {} steps", last.steps);
        self.show(u64::from(done), episodes, facts);
    }

    fn show(&self, done: u64, episodes: u32, facts: String) {
        if self.on_terminal {
            self.bar.set_message(facts);
            self.bar.set_position(done);
        } else if done.is_multiple_of(RECENT as u64) || done == u64::from(episodes) {
            info!("{} {done}/{episodes}: {facts}", self.bar.prefix());
        }
    }
}

impl Drop for Console {
    fn drop(&mut self) {
        // What stands on the terminal stays.
        self.bar.abandon();
    }
}

/// The share of the recent episodes that ended at the exit; 0 before the first.
pub(super) fn recent_success(records: &Records) -> f64 {
    let escapes = records.recent(RECENT).filter(|record| record.terminated).count();
    escapes as f64 / records.len().clamp(1, RECENT) as f64
}
