//! Once its memory is full, the learner allocates nothing but the list of its decisions.

use agent_node::learning::{
    dyna_q::DynaQ,
    image::Image,
    settings::{Preset, Settings},
};
use allocation_counter::measure;

fn image(number: usize) -> Image {
    Image::try_from([number as u8; Image::BYTES].as_slice()).expect("the size of an image")
}

#[test]
fn a_step_of_the_learner_allocates_nothing_but_its_decisions() {
    for preset in Preset::ALL {
        let settings = Settings { memory_capacity: 100, ..preset.settings() };
        let mut learner = DynaQ::new(settings, 0, 1).unwrap();
        let mut state_number = 0;
        for number in 0..1000 {
            let (state, next) = (image(number), image(number + 1));
            let terminated = number % 10 == 9;
            let mut action = None;
            let to_act = measure(|| action = Some(learner.act(&[(&state, 0.5)])[0].action));
            let to_learn = measure(|| {
                if number % 10 == 0 {
                    state_number = learner.begin_episode(&state);
                }
                let action = action.unwrap();
                state_number = learner.remember(state_number, action, -0.1, terminated, &next);
                learner.plan();
                if terminated {
                    learner.end_episode();
                }
            });
            assert!(to_act.count_total <= 1, "{preset}, step {number}: {to_act:?}");
            // The ring of images grows for longer than the memory: it is twice as long.
            let is_full = number > 300;
            assert!(!is_full || to_learn.count_total == 0, "{preset}, step {number}: {to_learn:?}");
        }
    }
}
