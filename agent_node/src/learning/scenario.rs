//! In which of the simulator's rooms an episode takes place.

use rand::RngExt;
use task::Scenario;

use super::seeds::{Purpose, episode_generator};

/// One of them, drawn anew for each episode.
pub const MIXED: &str = "mixed";

/// The room of an episode: the scenario itself, or the one that is drawn where it is [`MIXED`].
pub fn room_of_episode(scenario: &str, purpose: Purpose, run_seed: u64, episode: u32) -> &str {
    match scenario {
        MIXED => {
            let mut generator = episode_generator(purpose, run_seed, episode);
            Scenario::ALL[generator.random_range(0..Scenario::ALL.len())].name()
        }
        room => room,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mixed_run_visits_all_rooms_alike_and_always_in_the_same_order() {
        let room = |episode| room_of_episode(MIXED, Purpose::Training, 3, episode);
        let rooms: Vec<&str> = (0..8000).map(room).collect();
        for name in Scenario::ALL.map(Scenario::name) {
            let count = rooms.iter().filter(|room| **room == name).count();
            assert!((880..1120).contains(&count), "{name}: {count}");
        }
        assert!((0..8000).map(room).eq(rooms.iter().copied()));
        let test = |episode| room_of_episode(MIXED, Purpose::Test, 3, episode);
        assert!(!(0..8000).map(test).eq(rooms));
        assert_eq!(room_of_episode("concave", Purpose::Training, 3, 7), "concave");
    }
}
