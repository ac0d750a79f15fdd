use super::fabricated::{between_moving_obstacles, escape, nothing};
use super::*;

/// What every picture must be: well-formed SVG, drawn to its end, that needs nothing else.
fn assert_whole(svg: &str) {
    resvg::usvg::Tree::from_str(svg, &resvg::usvg::Options::default()).unwrap();
    for reference in ["href", "url(", "<style", "<script", "NaN", "inf"] {
        assert!(!svg.contains(reference), "{reference}");
    }
    assert!(svg.contains("<title>") && svg.contains("<desc>"));
}

/// How many elements of a class there are.
fn count(svg: &str, class: &str) -> usize {
    svg.matches(&format!("class='{class}'")).count()
}

/// The pictures of a single escape.
fn pictures(escape: &Escape) -> [String; 4] {
    let escapes = std::slice::from_ref(escape);
    [paths(escapes), states(escape, pick_states(escape)), rooms(escapes), trails(escape)]
}

#[test]
fn a_step_is_an_arrow_or_a_cross() {
    let escapes = [escape(9, &[]), escape(4, &[2, 3])];
    // The legend of the paths has an arrow for each.
    for (svg, signs) in [(paths(&escapes), 2), (rooms(&escapes), 0)] {
        assert_eq!((count(&svg, "step"), count(&svg, "blocked")), (9 + 4 + signs, 2));
        assert!(svg.contains("9 steps") && svg.contains("6 steps, 2 blocked"));
        assert_whole(&svg);
    }
}

#[test]
fn the_pieces_of_an_obstacle_are_drawn_as_one() {
    let mut escape = escape(3, &[]);
    let piece = Shape::Polygon(vec![[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]]);
    escape.moments[0].scene.obstacles = vec![piece; 96];
    let filled = format!("Z' fill='{}'", colours::OBSTACLE);
    assert_eq!(rooms(&[escape]).matches(&filled).count(), 1);
}

#[test]
fn a_failure_is_called_one() {
    let mut escape = escape(3, &[1]);
    escape.escaped = false;
    assert!(pictures(&escape)[0].contains("not out in 4 steps"));
}

#[test]
fn the_last_arrow_ends_where_the_robot_left() {
    // At x = 0.1 m and y = 1.1 m.
    assert!(paths(&[escape(3, &[])]).contains("M100 -1100L"));
}

#[test]
fn sampled_states_are_named_in_both_pictures() {
    let escape = escape(12, &[]);
    assert_eq!(pick_states(&escape), [0, 5, 10]);
    let [paths, states, ..] = pictures(&escape);
    for name in ["A", "B", "C"] {
        assert!(paths.contains(&format!(">{name}</text>")), "{name}");
        assert!(states.contains(&format!(">{name}</text>")), "{name}");
    }
    assert_eq!((count(&states, "camera"), count(&states, "preference")), (3, 3));
    assert_eq!(count(&states, "action"), 3 * Action::COUNT);
    assert!(states.contains("step 6 of 12") && states.contains("temperature 0.1"));
    assert_whole(&states);
}

#[test]
fn only_what_moves_has_a_trail() {
    let svg = trails(&between_moving_obstacles(8));
    assert_eq!(count(&svg, "trail"), 1);
    assert!(!trails(&escape(8, &[])).contains("class='trail'"));
    assert_whole(&svg);
}

#[test]
fn a_film_has_a_frame_for_each_step_and_one_for_the_end() {
    for (escape, frames) in [(escape(5, &[1]), 7), (nothing(), 1)] {
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
fn hardly_any_escape_has_pictures_too() {
    for steps in 0..4 {
        let escape = escape(steps, &[]);
        assert!(pick_states(&escape).into_iter().all(|index| index < steps.max(1)));
        pictures(&escape).iter().for_each(|svg| assert_whole(svg));
    }
    pictures(&nothing()).iter().for_each(|svg| assert_whole(svg));
    assert_whole(&paths(&[]));
    assert_whole(&rooms(&[]));
}

#[test]
fn two_names_of_one_moment_share_a_badge() {
    let svg = paths(&[escape(1, &[])]);
    assert!(svg.contains(">ABC</text>"));
}

#[test]
fn broken_values_have_pictures_too() {
    for value in [0.0, -7.0, f32::NAN, f32::NEG_INFINITY] {
        let mut escape = escape(5, &[]);
        for moment in &mut escape.moments {
            moment.values = [value; Action::COUNT];
        }
        pictures(&escape).iter().for_each(|svg| assert_whole(svg));
    }
}
