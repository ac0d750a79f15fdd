use super::fixtures::{empty_episode, escape, escape_with_moving_cylinder};
use super::*;

/// Asserts that a figure is a well-formed SVG file without references to other resources.
fn assert_self_contained(svg: &str) {
    resvg::usvg::Tree::from_str(svg, &resvg::usvg::Options::default()).unwrap();
    for reference in ["href", "url(", "<style", "<script", "NaN", "inf"] {
        assert!(!svg.contains(reference), "{reference}");
    }
    assert!(svg.contains("<title>") && svg.contains("<desc>"));
}

/// Returns the number of elements with the given class.
fn count(svg: &str, class: &str) -> usize {
    svg.matches(&format!("class='{class}'")).count()
}

/// Returns the figures of a single escape.
fn figures(escape: &Escape) -> [String; 4] {
    let escapes = std::slice::from_ref(escape);
    [paths(escapes), states(escape, sample_states(escape)), rooms(escapes), trails(escape)]
}

#[test]
fn a_step_is_an_arrow_or_a_cross() {
    let escapes = [escape(9, &[]), escape(4, &[2, 3])];
    // The legend of `paths` has an additional arrow for each path.
    for (svg, symbols) in [(paths(&escapes), 2), (rooms(&escapes), 0)] {
        assert_eq!((count(&svg, "step"), count(&svg, "blocked")), (9 + 4 + symbols, 2));
        assert!(svg.contains("9 steps") && svg.contains("6 steps, 2 blocked"));
        assert_self_contained(&svg);
    }
}

#[test]
fn the_shapes_of_an_obstacle_are_drawn_as_one_path() {
    let mut escape = escape(3, &[]);
    let shape = Shape::Polygon(vec![[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]]);
    escape.moments[0].scene.obstacles = vec![shape; 96];
    let filled = format!("Z' fill='{}'", colours::OBSTACLE);
    assert_eq!(rooms(&[escape]).matches(&filled).count(), 1);
}

#[test]
fn a_failed_episode_is_labelled_as_failed() {
    let mut escape = escape(3, &[1]);
    escape.escaped = false;
    assert!(figures(&escape)[0].contains("failed after 4 steps"));
}

#[test]
fn the_last_arrow_ends_at_the_last_pose() {
    // The last pose is at x = 0.1 m and y = 1.1 m.
    assert!(paths(&[escape(3, &[])]).contains("M100 -1100L"));
}

#[test]
fn sampled_states_are_labelled_in_both_figures() {
    let escape = escape(12, &[]);
    assert_eq!(sample_states(&escape), [0, 5, 10]);
    let [paths, states, ..] = figures(&escape);
    for label in ["A", "B", "C"] {
        assert!(paths.contains(&format!(">{label}</text>")), "{label}");
        assert!(states.contains(&format!(">{label}</text>")), "{label}");
    }
    assert_eq!((count(&states, "camera"), count(&states, "preference")), (3, 3));
    assert_eq!(count(&states, "action"), 3 * Action::COUNT);
    assert!(states.contains("step 6 of 12") && states.contains("temperature 0.1"));
    assert_self_contained(&states);
}

#[test]
fn only_moving_obstacles_have_a_trail() {
    let svg = trails(&escape_with_moving_cylinder(8));
    assert_eq!(count(&svg, "trail"), 1);
    assert!(!trails(&escape(8, &[])).contains("class='trail'"));
    assert_self_contained(&svg);
}

#[test]
fn an_animation_has_a_frame_for_each_of_the_first_60_steps_and_a_final_frame() {
    for (escape, frames) in [(escape(5, &[1]), 7), (escape(70, &[]), 61), (empty_episode(), 1)] {
        let file = animation(&escape);
        let mut decoder = gif::DecodeOptions::new().read_info(&file[..]).unwrap();
        let mut delays = Vec::new();
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            delays.push(frame.delay);
        }
        assert_eq!(delays.len(), frames);
        assert!(delays[frames - 1] > 2 * delays[0] || frames == 1);
        assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
    }
}

#[test]
fn short_and_empty_episodes_have_figures() {
    for steps in 0..4 {
        let escape = escape(steps, &[]);
        assert!(sample_states(&escape).into_iter().all(|index| index < steps.max(1)));
        figures(&escape).iter().for_each(|svg| assert_self_contained(svg));
    }
    figures(&empty_episode()).iter().for_each(|svg| assert_self_contained(svg));
    assert_self_contained(&paths(&[]));
    assert_self_contained(&rooms(&[]));
}

#[test]
fn labels_of_the_same_moment_share_a_badge() {
    let svg = paths(&[escape(1, &[])]);
    assert!(svg.contains(">ABC</text>"));
}

#[test]
fn escapes_with_constant_or_non_finite_q_values_have_figures() {
    for value in [0.0, -7.0, f32::NAN, f32::NEG_INFINITY] {
        let mut escape = escape(5, &[]);
        for moment in &mut escape.moments {
            moment.values = [value; Action::COUNT];
        }
        figures(&escape).iter().for_each(|svg| assert_self_contained(svg));
    }
}
