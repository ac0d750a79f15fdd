//! Estimates how short the paths to the exit can be for a robot that sees only through its camera.
//! Writes `results/camera_limit.json` and the table in `docs/results.md`. `evac camera-limit` runs
//! this program.
//!
//! The robot knows the rules of the scenario and its own pose, but not where the exit and the
//! cylinders are. At each step, rooms that are consistent with all images so far are sampled; a search
//! over them selects the action with the lowest expected number of steps.
//!
//! - The lower bound is the expected number of steps if the robot is told the room after a few
//!   steps: no policy that sees only the camera has fewer on average, up to sampling errors.
//! - The planner acts by this search at each step, so a policy with its number of steps exists, for
//!   a robot that knows its pose. The walls show the pose; their brightness tells them apart.

mod belief;
mod planner;

use std::{
    fs,
    num::NonZeroU64,
    path::PathBuf,
    sync::{
        Mutex,
        atomic::{AtomicU32, Ordering},
    },
};

use anyhow::{Context, ensure};
use clap::Parser;
use experiments::{replace_section, repository};
use report::confidence::Mean;
use serde::Serialize;
use sim_node::{
    camera::{Camera, CameraSettings},
    world::{World, WorldSettings, shortest_path_length},
};
use task::{
    Scenario,
    seeds::{Purpose, episode_seed},
};

use self::{belief::Belief, planner::Planner};

/// The scenarios: the others are between them, or have moving obstacles.
const SCENARIOS: [Scenario; 3] = [Scenario::Empty, Scenario::ThreeCylinders, Scenario::Concave];
/// The seed of the evaluations in docs/results.md.
const SEED: u64 = 1;
/// An episode of the planner ends after this many steps.
const MAX_STEPS: u32 = 100;

/// Estimates how short paths can be for a robot that sees only through its camera.
#[derive(Parser)]
struct CommandLine {
    /// Number of episodes per scenario: the first ones of an evaluation
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    episodes: u32,
    /// Number of rooms that represent what the robot knows
    #[arg(long, default_value_t = 48, value_parser = clap::value_parser!(u64).range(1..=10_000))]
    rooms: u64,
    /// Number of steps after which the search assumes that the robot is told the room
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=6))]
    depth: u32,
    /// Number of threads
    #[arg(long, default_value_t = 2)]
    jobs: usize,
    /// Output file (JSON)
    #[arg(long, default_value = "results/camera_limit.json")]
    out: PathBuf,
    /// Markdown page whose section camera-limit is replaced [default: docs/results.md]
    #[arg(long)]
    results: Option<PathBuf>,
}

/// The steps of one episode.
#[derive(Clone, Copy)]
struct Episode {
    shortest: u32,
    /// The expected number of steps at the start that the robot loses because it does not know the
    /// room, at least.
    ignorance: f64,
    planner: u32,
}

/// Mean steps over the episodes of a scenario, with 95 % confidence intervals.
#[derive(Serialize)]
struct Limit {
    scenario: &'static str,
    episodes: usize,
    /// Number of episodes in which the planner reached the exit.
    successes: usize,
    /// The full-knowledge shortest paths.
    shortest: Mean,
    lower_bound: Mean,
    planner: Mean,
}

fn main() -> anyhow::Result<()> {
    let command_line = CommandLine::parse();
    let mut limits = Vec::new();
    for scenario in SCENARIOS {
        let limit = measure(scenario, &command_line)?;
        eprintln!(
            "{scenario}: full knowledge {:.2}, lower bound {:.2}, planner {:.2} steps",
            limit.shortest.mean, limit.lower_bound.mean, limit.planner.mean
        );
        limits.push(limit);
    }
    let json = serde_json::to_string_pretty(&limits)? + "\n";
    fs::write(&command_line.out, json).with_context(|| command_line.out.display().to_string())?;
    let default_page = repository().join("docs/results.md");
    let page = command_line.results.as_ref().unwrap_or(&default_page);
    replace_section(page, "camera-limit", &table(&limits))
}

fn measure(scenario: Scenario, command_line: &CommandLine) -> anyhow::Result<Limit> {
    let episodes = Mutex::new(Vec::new());
    let next = AtomicU32::new(0);
    let work = || -> anyhow::Result<()> {
        loop {
            let episode = next.fetch_add(1, Ordering::Relaxed);
            if episode >= command_line.episodes {
                return Ok(());
            }
            let seed = episode_seed(Purpose::Evaluation, SEED, episode);
            let result = run(scenario, seed, command_line)?;
            episodes.lock().expect("no thread panics with this lock").push((episode, result));
        }
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..command_line.jobs.max(1)).map(|_| scope.spawn(work)).collect();
        threads.into_iter().try_for_each(|thread| thread.join().expect("no thread panics"))
    })?;
    let mut episodes = episodes.into_inner().expect("no thread panics with this lock");
    // The order, and with it the rounding of the means, must not depend on timing.
    episodes.sort_by_key(|(episode, _)| *episode);
    let mean = |of: fn(&Episode) -> f64| {
        let values: Vec<f64> = episodes.iter().map(|(_, episode)| of(episode)).collect();
        Mean::of(&values).context("no episode")
    };
    Ok(Limit {
        scenario: scenario.name(),
        episodes: episodes.len(),
        successes: episodes.iter().filter(|(_, episode)| episode.planner < MAX_STEPS).count(),
        shortest: mean(|episode| f64::from(episode.shortest))?,
        // The rooms that agree with the first image have the same mean length of the shortest paths
        // as the true rooms, so only the loss needs to be averaged over them.
        lower_bound: mean(|episode| f64::from(episode.shortest) + episode.ignorance)?,
        planner: mean(|episode| f64::from(episode.planner))?,
    })
}

fn run(
    scenario: Scenario,
    seed: NonZeroU64,
    command_line: &CommandLine,
) -> anyhow::Result<Episode> {
    let camera = Camera::new(CameraSettings::default())?;
    let mut truth = World::new(WorldSettings::default(), scenario, 0)?;
    truth.reset(Some(seed), None)?;
    let shortest = shortest_path_length(&truth).context("no path to the exit")?;
    let start = truth.clone();
    let mut belief = Belief::new(&camera, &start, seed.get());
    let (mut rooms, count) = (Vec::new(), command_line.rooms as usize);
    let mut ignorance = None;
    let mut planner = 0;
    while planner < MAX_STEPS {
        belief.complete(&mut rooms, count);
        let pose = *truth.robot();
        let mut search = Planner::new(&camera, &rooms);
        let (action, steps) = search.best(&pose, command_line.depth);
        ignorance.get_or_insert(steps - search.known(&pose));
        planner += 1;
        if truth.step(action)?.terminated {
            break;
        }
        // Keeps the rooms in which the robot would be at the same pose and see the same image.
        let (pose, image) = (*truth.robot(), camera.render(&truth));
        rooms.retain_mut(|room| {
            room.place_robot(belief.seen[belief.seen.len() - 1].0);
            let agrees = room.attempt(action).robot == pose;
            room.place_robot(pose);
            agrees && camera.render(room) == image
        });
        belief.seen.push((pose, image));
    }
    let ignorance = ignorance.unwrap_or_default();
    ensure!(ignorance > -1e-9, "knowing less of the room saves {} steps", -ignorance);
    ensure!(planner >= shortest, "the planner needs {planner} of at least {shortest} steps");
    Ok(Episode { shortest, ignorance, planner })
}

fn table(limits: &[Limit]) -> String {
    let mut table = "| scenario | full knowledge | camera, lower bound | camera, planner | \
                     planner / full knowledge |\n|---|---|---|---|---|\n"
        .to_owned();
    for limit in limits {
        let number = |mean: &Mean| match mean.interval {
            Some((low, high)) => format!("{:.2} ± {:.2}", mean.mean, (high - low) / 2.0),
            None => format!("{:.2}", mean.mean),
        };
        table += &format!(
            "| {} | {} | {} | {} | {:.3} |\n",
            limit.scenario,
            number(&limit.shortest),
            number(&limit.lower_bound),
            number(&limit.planner),
            limit.planner.mean / limit.shortest.mean
        );
    }
    table
}
