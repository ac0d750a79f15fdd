//! Tests that, once the replay memory is full, the learner allocates only its list of decisions.

use allocation_counter::measure;
use learning::{dyna_q::DynaQ, settings::Preset};
use task::{Image, Step};

fn image(number: usize) -> Image {
    Image::try_from([number as u8; Image::BYTES].as_slice())
        .expect("the buffer has the size of an image")
}

#[test]
fn a_step_allocates_only_the_decisions() {
    for preset in Preset::ALL {
        let settings = preset.settings().with(|s| s.replay.capacity = 100);
        let mut learner = DynaQ::new(settings, 0, 1).unwrap();
        let mut state = 0;
        for number in 0..2000 {
            let (first, terminated) = (image(number), number % 10 == 9);
            let image = image(number + 1);
            let step = Step { image, reward: -0.1, terminated, truncated: false, blocked: false };
            let begin = measure(|| {
                if number % 10 == 0 {
                    state = learner.begin_episode(&first);
                }
            });
            let mut action = None;
            let act = measure(|| action = Some(learner.act(&[(state, 0.5)])[0].action));
            let learn = measure(|| {
                state = learner.store(state, action.unwrap(), &step);
                learner.plan();
                if terminated {
                    learner.end_episode();
                }
            });
            assert!(act.count_total <= 1, "{preset}, step {number}: {act:?}");
            // After step 900, the replay memory reuses image chunks.
            let is_full = number > 900;
            let total = begin.count_total + learn.count_total;
            assert!(!is_full || total == 0, "{preset}, step {number}: {total} allocations");
        }
    }
}
