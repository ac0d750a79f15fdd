//! Once its memory is full, the learner allocates nothing but the list of its decisions.

use allocation_counter::measure;
use learning::{dyna_q::DynaQ, settings::Preset};
use task::{Image, Step};

fn image(number: usize) -> Image {
    Image::try_from([number as u8; Image::BYTES].as_slice()).expect("the size of an image")
}

#[test]
fn a_step_of_the_learner_allocates_nothing_but_its_decisions() {
    for preset in Preset::ALL {
        let settings = preset.settings().with(|s| s.replay.capacity = 100);
        let mut learner = DynaQ::new(settings, 0, 1).unwrap();
        let mut state = 0;
        for number in 0..2000 {
            let (first, terminated) = (image(number), number % 10 == 9);
            let image = image(number + 1);
            let step = Step { image, reward: -0.1, terminated, truncated: false, blocked: false };
            let to_begin = measure(|| {
                if number % 10 == 0 {
                    state = learner.begin_episode(&first);
                }
            });
            let mut action = None;
            let to_act = measure(|| action = Some(learner.act(&[(state, 0.5)])[0].action));
            let to_learn = measure(|| {
                state = learner.remember(state, action.unwrap(), &step);
                learner.plan();
                if terminated {
                    learner.end_episode();
                }
            });
            assert!(to_act.count_total <= 1, "{preset}, step {number}: {to_act:?}");
            // Until the first chunk of images is used again.
            let is_full = number > 900;
            let total = to_begin.count_total + to_learn.count_total;
            assert!(!is_full || total == 0, "{preset}, step {number}: {total} allocations");
        }
    }
}
