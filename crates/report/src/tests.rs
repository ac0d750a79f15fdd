use task::Image;

use super::*;

/// Returns the records of a plausible training run, without randomness.
fn records(episodes: u32) -> Vec<EpisodeRecord> {
    (0..episodes)
        .map(|episode| {
            let progress = f64::from(episode) / f64::from(episodes);
            let epsilon = 0.1 + 0.9 * (-8.0 * progress).exp();
            let steps = (12.0 + 300.0 * epsilon * f64::from(episode * 37 % 11) / 5.0) as u32;
            EpisodeRecord {
                episode,
                steps,
                episode_return: -0.1 * (steps - 1) as f32,
                epsilon,
                loss: (episode > 0).then_some(0.05 * epsilon),
                blocked: steps / 7,
                terminated: true,
            }
        })
        .collect()
}

fn evaluation() -> Evaluation {
    Evaluation {
        scenario: "empty".into(),
        episodes: 1000,
        successes: 943,
        success_rate: 0.943,
        max_steps: 200,
        seed: 1,
        mean_steps: Some(11.14),
        oracle_mean_steps: Some(9.05),
        optimality_ratio: Some(1.231),
        blocked_per_100_steps: 0.4,
        collision_free_rate: 0.96,
    }
}

fn frame(caption: &str) -> CaptionedFrame {
    let image = Image::try_from(&[90; Image::BYTES][..]).unwrap();
    CaptionedFrame { image, caption: caption.into() }
}

fn page(
    records: &[EpisodeRecord],
    evaluation: Option<&Evaluation>,
    frames: &[CaptionedFrame],
) -> String {
    let run = RunSummary {
        scenario: "empty",
        preset: "paper",
        seed: 0,
        episodes: 1000,
        steps: 51_316,
        wall_s: 1142.0,
        steps_per_s: 44.9,
        update_us: None,
    };
    Report { run, records, evaluation, frames, escapes: None }.to_html().unwrap()
}

#[test]
fn the_page_is_self_contained() {
    let html = page(&records(1000), Some(&evaluation()), &[frame("Step 3")]);
    for reference in ["http://", "https://", "<script", "<link", "@import", "url(", "src=\"/"] {
        assert!(!html.contains(reference), "{reference}");
    }
    assert_eq!(html.matches("src=").count(), html.matches("src=\"data:image/png;base64,").count());
    assert_eq!(html.matches("<svg").count(), 6);
    assert_eq!(html.matches("</svg>").count(), 6);
}

#[test]
fn plots_use_the_colours_of_the_page() {
    let html = page(&records(10), None, &[]);
    let (_, body) = html.split_once("</style>").unwrap();
    assert!(!body.contains("fill=\"#") && !body.contains("stroke=\"#"));
}

#[test]
fn the_page_shows_formatted_results() {
    let html = page(&records(1000), Some(&evaluation()), &[]);
    for text in ["51,316", "19:02", "94.3\u{a0}%", "92.7\u{a0}% to 95.6\u{a0}%", "1.23", "Step"] {
        assert!(html.contains(text), "{text}");
    }
    assert!(!html.contains("not been evaluated"));
}

#[test]
fn the_page_says_that_there_is_no_evaluation_yet() {
    assert!(page(&records(3), None, &[]).contains("not been evaluated yet"));
}

#[test]
fn unavailable_metrics_of_an_evaluation_are_omitted() {
    let unknown = Evaluation {
        successes: 0,
        success_rate: 0.0,
        mean_steps: None,
        oracle_mean_steps: None,
        optimality_ratio: None,
        ..evaluation()
    };
    let html = page(&records(3), Some(&unknown), &[]);
    assert!(html.contains("no episode succeeded"));
    assert!(!html.contains("shortest path"));
}

#[test]
fn a_training_run_with_few_or_no_episodes_has_a_page() {
    for (episodes, plots, missing) in [(0, 0, 0), (1, 5, 1), (2, 6, 0)] {
        let html = page(&records(episodes), None, &[]);
        assert_eq!(html.matches("<svg").count(), plots, "{episodes} episodes");
        assert_eq!(html.matches("No data yet").count(), missing);
        assert_eq!(html.contains("No episode has ended yet"), episodes == 0);
        assert!(!html.contains("NaN") && !html.contains("inf\""));
    }
}

#[test]
fn a_training_run_with_constant_values_has_a_page() {
    for (steps, loss) in [(1, None), (10_000, Some(0.0)), (7, Some(1e-12))] {
        let mut records = records(100);
        for record in &mut records {
            record.steps = steps;
            record.episode_return = 0.0;
            record.epsilon = 0.0;
            record.loss = loss;
            record.blocked = 0;
        }
        let html = page(&records, None, &[]);
        assert!(!html.contains("NaN") && html.contains("<svg"));
    }
}

#[test]
fn the_page_of_a_long_training_run_stays_below_1_mb() {
    let html = page(&records(1_000_000), None, &[]);
    assert!(html.len() < 1_000_000, "{} bytes", html.len());
    assert!(html.contains("1 of every 1000 episodes"));
}

#[test]
fn captions_are_escaped() {
    let frame = frame("<script>alert(1)</script>");
    assert!(!page(&[], None, &[frame]).contains("<script>"));
}
