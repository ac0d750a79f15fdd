//! The results as Markdown tables.

use report::numbers::decimal;
use sim_node::reality::Randomization;
use task::{Evaluation, Scenario};

use crate::{
    results::{LEVELS, Results},
    variants::Variant,
};

/// Returns one table per metric and level of randomization, with a row per variant and a column per
/// scenario. Missing results are shown as a dash.
pub fn tables(variants: &[Variant], results: &Results) -> String {
    let table = |title: &str, level: Randomization, cell: &dyn Fn(&Evaluation) -> String| {
        let names = Scenario::ALL.map(Scenario::name).join(" | ");
        let world = match level {
            Randomization::None => "without perturbations".to_owned(),
            level => format!("with `{}` perturbations", level.name()),
        };
        let mut table = format!(
            "{title}, {world}:\n\n| | {names} |\n|{}\n",
            "---|".repeat(1 + Scenario::ALL.len())
        );
        for variant in variants {
            let cells = Scenario::ALL.map(|scenario| {
                let result = results.get(variant.name);
                let evaluations = result.and_then(|result| result.evaluations.get(level.name()));
                let evaluation =
                    evaluations.into_iter().flatten().find(|e| e.scenario == scenario.name());
                evaluation.map_or_else(|| "–".to_owned(), cell)
            });
            table += &format!("| {} | {} |\n", variant.name, cells.join(" | "));
        }
        table
    };
    let steps = |e: &Evaluation| e.mean_steps.map_or("–".to_owned(), |steps| decimal(steps, 1));
    let tables = LEVELS.map(|level| {
        [
            table("Success rate within 200 steps (%)", level, &|e| {
                decimal(100.0 * e.success_rate, 2)
            }),
            table("Blocked moves per 100 steps", level, &|e| decimal(e.blocked_per_100_steps, 2)),
            table("Mean steps of the successful episodes", level, &steps),
        ]
        .join("\n")
    });
    tables.join("\n")
}
