//! The replay memory: a first-in-first-out queue of experiences (the paper's section 2.3).
//!
//! Consecutive experiences share an image, so images are stored once, as bytes, and an experience
//! points at two of them.

use rand::{Rng, RngExt};

use super::{action::Action, image::Image};

/// One experience: `(s, a, s', R)`, and whether `s'` ended the episode at the exit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experience {
    /// The number of the image of `s`.
    pub state: u64,
    /// The number of the image of `s'`.
    pub next_state: u64,
    /// `a`
    pub action: Action,
    /// `R`
    pub reward: f32,
    /// No bootstrap from here: the exit is reached. A truncated episode goes on as far as values
    /// are concerned.
    pub terminated: bool,
}

/// The memory, a ring of experiences beside a ring of images.
///
/// Images are numbered in the order of their coming. An experience brings at most two of them, the
/// first of an episode and its own, so a ring of twice the capacity never overwrites an image that
/// an experience still points at.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplayMemory {
    capacity: usize,
    experiences: Vec<Experience>,
    /// Where the next experience goes once the memory is full.
    oldest: usize,
    images: Vec<[u8; Image::BYTES]>,
    /// The number of the next image.
    next_image: u64,
}

impl ReplayMemory {
    /// An empty memory of at most `capacity` experiences.
    pub fn new(capacity: usize) -> ReplayMemory {
        ReplayMemory {
            capacity,
            experiences: Vec::new(),
            oldest: 0,
            images: Vec::new(),
            next_image: 0,
        }
    }

    /// A memory as it was: its experiences from the oldest on, which has the index `oldest`; the
    /// images from number `first` on. Indices are what updates draw, so they must be the same.
    pub(super) fn restore(
        capacity: usize,
        mut experiences: Vec<Experience>,
        oldest: usize,
        first: u64,
        images: &[[u8; Image::BYTES]],
    ) -> ReplayMemory {
        let mut memory = ReplayMemory::new(capacity);
        memory.next_image = first;
        for image in images {
            memory.push_image(image);
        }
        experiences.rotate_right(oldest);
        (memory.experiences, memory.oldest) = (experiences, oldest);
        memory
    }

    /// How many experiences there are.
    pub fn len(&self) -> usize {
        self.experiences.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.experiences.is_empty()
    }

    /// Stores the first image of an episode.
    pub fn begin_episode(&mut self, image: &Image) {
        self.push_image(image.bytes());
    }

    /// Stores what an action led to from the image that was stored last.
    pub fn store(&mut self, action: Action, reward: f32, terminated: bool, next: &Image) {
        let next_state = self.push_image(next.bytes());
        let state = next_state - 1;
        let experience = Experience { state, next_state, action, reward, terminated };
        if self.experiences.len() < self.capacity {
            self.experiences.push(experience);
        } else {
            self.experiences[self.oldest] = experience;
            self.oldest = (self.oldest + 1) % self.capacity;
        }
    }

    /// Draws different experiences uniformly, as indices for [`ReplayMemory::get`], one for each
    /// place in the batch; false while there are fewer.
    ///
    /// What is drawn depends on the generator and the length only. So it is known before an
    /// experience is there: with `one_more`, the draw is that after the next [`ReplayMemory::store`].
    ///
    /// This is Floyd's algorithm (Bentley, Programming Pearls, CACM 30(9), 1987), in place.
    pub fn draw(&self, batch: &mut [usize], one_more: bool, random: &mut impl Rng) -> bool {
        let length = (self.len() + usize::from(one_more)).min(self.capacity);
        let Some(first) = length.checked_sub(batch.len()) else {
            return false;
        };
        for place in 0..batch.len() {
            let last = first + place;
            let index = random.random_range(0..=last);
            batch[place] = if batch[..place].contains(&index) { last } else { index };
        }
        true
    }

    /// The index that the next experience will have.
    pub fn next_index(&self) -> usize {
        if self.len() < self.capacity { self.len() } else { self.oldest }
    }

    /// The experience at an index below [`ReplayMemory::len`].
    pub fn get(&self, index: usize) -> Experience {
        self.experiences[index]
    }

    /// The index of the oldest experience.
    pub(super) fn oldest_index(&self) -> usize {
        self.oldest
    }

    /// The bytes of the image with a number that an experience holds.
    pub fn image(&self, number: u64) -> &[u8; Image::BYTES] {
        &self.images[self.slot(number)]
    }

    /// The image that was stored last.
    pub fn latest_image(&self) -> Option<&[u8; Image::BYTES]> {
        (self.next_image > 0).then(|| self.image(self.next_image - 1))
    }

    /// The experiences, the oldest first.
    pub fn oldest_first(&self) -> impl Iterator<Item = Experience> + '_ {
        let (newer, older) = self.experiences.split_at(self.oldest);
        older.iter().chain(newer).copied()
    }

    /// The numbers of the images that are still needed: those of the experiences, and the last.
    pub fn needed_images(&self) -> std::ops::Range<u64> {
        let oldest = self.oldest_first().next().map(|experience| experience.state);
        oldest.unwrap_or(self.next_image.saturating_sub(1))..self.next_image
    }

    fn push_image(&mut self, bytes: &[u8; Image::BYTES]) -> u64 {
        let number = self.next_image;
        let slot = self.slot(number);
        // The ring grows up to its size: a short training stays small.
        if slot >= self.images.len() {
            self.images.resize(slot + 1, [0; Image::BYTES]);
        }
        self.images[slot] = *bytes;
        self.next_image += 1;
        number
    }

    fn slot(&self, number: u64) -> usize {
        (number % (2 * self.capacity as u64 + 2)) as usize
    }
}

#[cfg(test)]
mod tests {
    use std::collections::{HashSet, VecDeque};

    use proptest::prelude::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn image(number: usize) -> Image {
        let bytes: Vec<u8> = (0..Image::BYTES).map(|i| (number * 31 + i) as u8).collect();
        Image::try_from(bytes.as_slice()).unwrap()
    }

    proptest! {
        /// Against a plain queue of whole images, over episodes of any lengths.
        #[test]
        fn it_is_a_queue_of_experiences(
            capacity in 1usize..40,
            episodes in prop::collection::vec(1usize..12, 1..40),
        ) {
            let mut memory = ReplayMemory::new(capacity);
            let mut model = VecDeque::new();
            let mut number = 0;
            for steps in episodes {
                let mut state = image(number);
                memory.begin_episode(&state);
                for step in 0..steps {
                    number += 1;
                    let action = Action::try_from((number % 7) as u8).unwrap();
                    let (next, terminated) = (image(number), step + 1 == steps);
                    memory.store(action, -0.1, terminated, &next);
                    model.push_back((state, action, terminated, next.clone()));
                    if model.len() > capacity {
                        model.pop_front();
                    }
                    state = next;
                }
                number += 1;
            }
            prop_assert_eq!(memory.len(), model.len());
            prop_assert!(memory.next_index() <= memory.len());
            for (experience, (state, action, terminated, next)) in memory.oldest_first().zip(model) {
                prop_assert_eq!(memory.image(experience.state), state.bytes());
                prop_assert_eq!(memory.image(experience.next_state), next.bytes());
                prop_assert_eq!(experience.action, action);
                prop_assert_eq!(experience.terminated, terminated);
            }
        }
    }

    #[test]
    fn a_batch_is_of_different_memories_and_all_are_drawn_alike() {
        let mut memory = ReplayMemory::new(100);
        memory.begin_episode(&image(0));
        for number in 1..=60 {
            memory.store(Action::try_from(0).unwrap(), -0.1, false, &image(number));
        }
        let mut random = ChaCha8Rng::from_seed([1; 32]);
        assert!(!memory.draw(&mut [0; 61], false, &mut random));
        let mut counts = [0u32; 60];
        for _ in 0..6000 {
            let mut batch = [0; 20];
            assert!(memory.draw(&mut batch, false, &mut random));
            assert_eq!(batch.iter().collect::<HashSet<_>>().len(), 20);
            batch.into_iter().for_each(|index| counts[index] += 1);
        }
        // 2,000 expected of each, with a standard deviation of 37.
        assert!(counts.iter().all(|count| (1800..2200).contains(count)), "{counts:?}");
    }
}
