//! The results as Markdown tables.

use task::Evaluation;
use task::Scenario;

use crate::{results::Results, variants::Variant};

/// Returns one table per metric, with a row per variant and a column per scenario. Missing results
/// are shown as a dash.
pub fn tables(variants: &[Variant], results: &Results) -> String {
    let table = |title: &str, cell: &dyn Fn(&Evaluation) -> String| {
        let names = Scenario::ALL.map(Scenario::name).join(" | ");
        let mut table =
            format!("{title}\n\n| | {names} |\n|---|{}\n", "---|".repeat(Scenario::ALL.len()));
        for variant in variants {
            let cells = Scenario::ALL.map(|scenario| {
                let of_variant = results.get(variant.key);
                let result = of_variant.and_then(|results| results.get(scenario.name()));
                result.map_or_else(|| "–".to_owned(), |result| cell(&result.evaluation))
            });
            table += &format!("| {} | {} |\n", variant.label, cells.join(" | "));
        }
        table
    };
    let steps =
        |e: &Evaluation| e.mean_steps.map_or("–".to_owned(), |steps| format!("{steps:.1}"));
    [
        table("Success rate within 200 steps (%):", &|e| format!("{:.2}", 100.0 * e.success_rate)),
        table("Blocked moves per 100 steps:", &|e| format!("{:.2}", e.blocked_per_100_steps)),
        table("Collision-free episodes (%):", &|e| format!("{:.1}", 100.0 * e.collision_free_rate)),
        table("Mean steps of the successful episodes:", &steps),
    ]
    .join("\n")
}
