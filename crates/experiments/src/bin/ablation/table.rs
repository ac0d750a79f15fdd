//! The figures as tables in Markdown.

use task::Evaluation;
use task::Scenario;

use crate::{Figures, variants::Variant};

/// A table for each figure, a row for each variant, a column for each scenario.
pub fn tables(variants: &[Variant], figures: &Figures) -> String {
    let table = |title: &str, cell: &dyn Fn(&Evaluation) -> String| {
        let names = Scenario::ALL.map(Scenario::name).join(" | ");
        let mut table = format!("{title}\n\n| | {names} |\n|---|{}\n", "---|".repeat(8));
        for variant in variants {
            let cells = Scenario::ALL.map(|scenario| {
                let evaluation = figures.get(variant.name).and_then(|of| of.get(scenario.name()));
                evaluation.map_or_else(|| "–".to_owned(), |reached| cell(&reached.evaluation))
            });
            table += &format!("| {} | {} |\n", variant.name, cells.join(" | "));
        }
        table
    };
    let steps =
        |e: &Evaluation| e.mean_steps.map_or("–".to_owned(), |steps| format!("{steps:.1}"));
    [
        table("Escapes within 200 steps, in %:", &|e| format!("{:.2}", 100.0 * e.success_rate)),
        table("Blocked moves per 100 steps:", &|e| format!("{:.2}", e.blocked_per_100_steps)),
        table("Episodes without a blocked move, in %:", &|e| {
            format!("{:.1}", 100.0 * e.collision_free_rate)
        }),
        table("Mean steps of the escapes:", &steps),
    ]
    .join("\n")
}
