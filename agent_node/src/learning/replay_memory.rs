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
/// first of an episode and its own, so a ring of twice the capacity, and two more for each room,
/// never overwrites an image that an experience still points at.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplayMemory {
    capacity: usize,
    rooms: usize,
    experiences: Vec<Experience>,
    /// Where the next experience goes once the memory is full.
    oldest: usize,
    images: Vec<[u8; Image::BYTES]>,
    /// The number of the next image.
    next_image: u64,
}

impl ReplayMemory {
    /// An empty memory of at most `capacity` experiences, which come from so many rooms in turn.
    pub fn new(capacity: usize, rooms: usize) -> ReplayMemory {
        ReplayMemory {
            capacity,
            rooms,
            experiences: Vec::new(),
            oldest: 0,
            images: Vec::new(),
            next_image: 0,
        }
    }

    /// A memory as it was: its experiences from the oldest on, which has the index `oldest`; the
    /// images from number `first` on. Indices are what updates draw, so they must be the same.
    pub(super) fn restore(
        (capacity, rooms): (usize, usize),
        mut experiences: Vec<Experience>,
        oldest: usize,
        first: u64,
        images: &[[u8; Image::BYTES]],
    ) -> ReplayMemory {
        let mut memory = ReplayMemory::new(capacity, rooms);
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

    /// Stores the first image of an episode; returns its number.
    pub fn begin_episode(&mut self, image: &Image) -> u64 {
        self.push_image(image.bytes())
    }

    /// Stores what an action led to from the image of a number; returns the number of the next one.
    pub fn store(
        &mut self,
        state: u64,
        action: Action,
        reward: f32,
        terminated: bool,
        next: &Image,
    ) -> u64 {
        let next_state = self.push_image(next.bytes());
        let experience = Experience { state, next_state, action, reward, terminated };
        if self.experiences.len() < self.capacity {
            self.experiences.push(experience);
        } else {
            self.experiences[self.oldest] = experience;
            self.oldest = (self.oldest + 1) % self.capacity;
        }
        next_state
    }

    /// Draws different experiences uniformly, as indices for [`ReplayMemory::get`], one for each
    /// place in the batch; false while there are fewer.
    ///
    /// What is drawn depends on the generator and the length only. So it is known before experiences
    /// are there: the draw is that after `more` further ones are stored.
    ///
    /// This is Floyd's algorithm (Bentley, Programming Pearls, CACM 30(9), 1987), in place.
    pub fn draw(&self, batch: &mut [usize], more: usize, random: &mut impl Rng) -> bool {
        let length = (self.len() + more).min(self.capacity);
        let Some(first) = length.checked_sub(batch.len()) else {
            return false;
        };
        for place in 0..batch.len() {
            let last = first + place;
            let index = random.random_range(0..=last);
            // As in rand's own, whose draws have no order either.
            if let Some(taken) = batch[..place].iter_mut().find(|taken| **taken == index) {
                *taken = last;
            }
            batch[place] = index;
        }
        true
    }

    /// Whether an index will be that of one of the next experiences, so many of them.
    pub fn is_among_next(&self, index: usize, more: usize) -> bool {
        let first = if self.len() < self.capacity { self.len() } else { self.oldest };
        (index + self.capacity - first) % self.capacity < more
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

    /// Fetches the images of a batch from main memory, all at once, which takes the time of a few:
    /// when they are converted one after the other, each would have to be waited for.
    pub fn fetch(&self, batch: &[usize]) {
        const CACHE_LINE: usize = 64;
        let mut sum = 0u8;
        for index in batch {
            let experience = self.get(*index);
            for number in [experience.next_state, experience.state] {
                let lines = self.image(number).iter().step_by(CACHE_LINE);
                sum = lines.fold(sum, |sum, byte| sum.wrapping_add(*byte));
            }
        }
        std::hint::black_box(sum);
    }

    /// The experiences, the oldest first.
    pub fn oldest_first(&self) -> impl Iterator<Item = Experience> + '_ {
        let (newer, older) = self.experiences.split_at(self.oldest);
        older.iter().chain(newer).copied()
    }

    /// The number of the next image.
    pub fn next_image(&self) -> u64 {
        self.next_image
    }

    /// The numbers of the images that the experiences need, and those since.
    pub fn needed_images(&self) -> std::ops::Range<u64> {
        let first = self.experiences.iter().map(|experience| experience.state).min();
        first.unwrap_or(self.next_image)..self.next_image
    }

    /// How many images are kept at most.
    pub(super) fn most_images(capacity: usize, rooms: usize) -> usize {
        2 * (capacity + rooms)
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
        (number % ReplayMemory::most_images(self.capacity, self.rooms) as u64) as usize
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
        /// Against a plain queue of whole images, over episodes of any lengths in several rooms.
        #[test]
        fn it_is_a_queue_of_experiences(
            capacity in 1usize..40,
            rooms in 1usize..4,
            lengths in prop::collection::vec(1usize..12, 1..60),
        ) {
            let mut memory = ReplayMemory::new(capacity, rooms);
            let mut model = VecDeque::new();
            let mut lengths = lengths.into_iter();
            let mut count = 0;
            let mut next_image = || {
                count += 1;
                image(count)
            };
            // The steps left, the image and its number, in each room.
            let mut states: Vec<Option<(usize, Image, u64)>> = vec![None; rooms];
            loop {
                for state in &mut states {
                    if state.is_none() && let Some(length) = lengths.next() {
                        let first = next_image();
                        let number = memory.begin_episode(&first);
                        *state = Some((length, first, number));
                    }
                }
                if states.iter().all(Option::is_none) {
                    break;
                }
                let more = states.iter().flatten().count();
                let expected: Vec<bool> =
                    (0..capacity).map(|index| memory.is_among_next(index, more)).collect();
                let mut written = vec![false; capacity];
                for state in &mut states {
                    let Some((left, before, number)) = state.take() else {
                        continue;
                    };
                    let action = Action::try_from((left % 7) as u8).unwrap();
                    let (next, terminated) = (next_image(), left == 1);
                    let index = (0..capacity).find(|index| memory.is_among_next(*index, 1));
                    written[index.unwrap()] = true;
                    let number = memory.store(number, action, -0.1, terminated, &next);
                    model.push_back((before, action, terminated, next.clone()));
                    if model.len() > capacity {
                        model.pop_front();
                    }
                    if left > 1 {
                        *state = Some((left - 1, next, number));
                    }
                }
                prop_assert_eq!(written, expected);
            }
            prop_assert_eq!(memory.len(), model.len());
            for (experience, (state, action, terminated, next)) in memory.oldest_first().zip(model) {
                prop_assert_eq!(memory.image(experience.state), state.bytes());
                prop_assert_eq!(memory.image(experience.next_state), next.bytes());
                prop_assert_eq!(experience.action, action);
                prop_assert_eq!(experience.terminated, terminated);
                prop_assert!(memory.needed_images().contains(&experience.state));
            }
        }
    }

    #[test]
    fn a_batch_is_of_different_memories_and_all_are_drawn_alike() {
        let mut memory = ReplayMemory::new(100, 1);
        let mut state = memory.begin_episode(&image(0));
        for number in 1..=60 {
            state = memory.store(state, Action::try_from(0).unwrap(), -0.1, false, &image(number));
        }
        let mut random = ChaCha8Rng::from_seed([1; 32]);
        assert!(!memory.draw(&mut [0; 61], 0, &mut random));
        let mut counts = [0u32; 60];
        for _ in 0..6000 {
            let mut batch = [0; 20];
            assert!(memory.draw(&mut batch, 0, &mut random));
            assert_eq!(batch.iter().collect::<HashSet<_>>().len(), 20);
            batch.into_iter().for_each(|index| counts[index] += 1);
        }
        // 2,000 expected of each, with a standard deviation of 37.
        assert!(counts.iter().all(|count| (1800..2200).contains(count)), "{counts:?}");
    }
}
