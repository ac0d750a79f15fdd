//! The replay memory: a first-in-first-out queue of transitions (section 2.3 of the paper).
//!
//! Consecutive transitions share an image, so each image is stored once, as bytes, and a transition
//! refers to its two images by number.

use std::{collections::VecDeque, sync::Arc};

use task::{Action, Image, Random};

use super::{
    greedy::ActionSet,
    observation::{HORIZON, Moment, tried},
};

/// A transition `(s, a, s', R)`, and whether the robot reached the exit in `s'`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    /// The number of the image of `s`.
    pub state: u64,
    /// The number of the image of `s'`.
    pub next_state: u64,
    /// The action `a`.
    pub action: Action,
    /// The reward `R`, including the extra reward for a blocked move.
    pub reward: f32,
    /// Whether the robot reached the exit in `s'`, so that the value of `s'` is 0. A transition
    /// that truncates an episode is not marked as terminated, so its target includes the value of
    /// `s'`.
    pub terminated: bool,
}

/// A stored image, and the action that led to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The bytes of the image, `[7, 20, 3]`.
    pub image: [u8; Image::BYTES],
    /// The difference between the number of this image and that of the previous image in the
    /// episode, and the action between them; `None` for the first image of an episode.
    pub before: Option<(u16, Action)>,
    /// The actions already taken in response to the same view in the same episode ([`tried`]);
    /// empty without repetition avoidance.
    pub tried: ActionSet,
}

/// A ring buffer of transitions, and the images that their observations need.
///
/// Images are numbered in the order in which they are stored, and kept in chunks; a chunk is
/// dropped once no observation needs its images. Clones share the chunks, which makes cloning
/// cheap.
///
/// # Examples
///
/// ```
/// use learning::replay_memory::ReplayMemory;
/// use task::{Action, EXIT_REWARD, Image, Random, STEP_REWARD};
///
/// let image = |brightness: u8| Image::try_from(vec![brightness; Image::BYTES]);
/// let forward = Action::try_from(3)?;
/// let mut memory = ReplayMemory::new(1000, 1, 1, false);
/// let first = memory.begin_episode(&image(0)?);
/// let second = memory.store(first, forward, STEP_REWARD, false, &image(100)?);
/// memory.store(second, forward, EXIT_REWARD, true, &image(200)?);
///
/// let mut batch = [0; 2];
/// assert!(memory.sample(&mut batch, 0, &mut Random::from_key([0; 4])));
/// assert!(batch.iter().any(|index| memory.get(*index).terminated));
/// assert_eq!(memory.get(0).next_state, second);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ReplayMemory {
    capacity: usize,
    /// Number of interleaved environments.
    environments: usize,
    /// Number of stacked images in an observation.
    frames: usize,
    /// Whether repetitions are avoided, so that views are compared.
    avoid_repetition: bool,
    transitions: Vec<Transition>,
    /// Index of the oldest transition, which the next one replaces once the replay memory is
    /// full.
    oldest: usize,
    /// Chunks of [`CHUNK`] images, shared with clones of the replay memory (copy-on-write).
    images: VecDeque<Arc<Vec<Frame>>>,
    /// The number of the first stored image.
    first_image: u64,
    /// The number of the next image.
    next_image: u64,
}

/// Number of images in a chunk.
const CHUNK: usize = 256;

impl ReplayMemory {
    /// Creates an empty replay memory for at most `capacity` transitions from `environments`
    /// interleaved environments, with observations of `frames` stacked images. With
    /// `avoid_repetition`, it records which actions were already taken in response to each view.
    pub fn new(
        capacity: usize,
        environments: usize,
        frames: usize,
        avoid_repetition: bool,
    ) -> ReplayMemory {
        ReplayMemory {
            capacity,
            environments,
            frames,
            avoid_repetition,
            transitions: Vec::new(),
            oldest: 0,
            images: VecDeque::new(),
            first_image: 0,
            next_image: 0,
        }
    }

    /// Creates a replay memory like this one but with saved contents: the transitions, oldest
    /// first, and the images, numbered from `first`.
    ///
    /// The oldest transition gets the index `oldest`, since samples are indices and must refer to
    /// the same transitions as before.
    pub(super) fn restore(
        &self,
        mut transitions: Vec<Transition>,
        oldest: usize,
        first: u64,
        frames: impl Iterator<Item = Frame>,
    ) -> ReplayMemory {
        let mut memory =
            ReplayMemory::new(self.capacity, self.environments, self.frames, self.avoid_repetition);
        (memory.first_image, memory.next_image) = (first, first);
        // The transitions come first, since they determine which images are kept.
        transitions.rotate_right(oldest);
        (memory.transitions, memory.oldest) = (transitions, oldest);
        for frame in frames {
            memory.push_frame(frame);
        }
        memory
    }

    /// Returns the number of transitions.
    pub fn len(&self) -> usize {
        self.transitions.len()
    }

    /// Returns the number of transitions after `more` further ones have been stored.
    pub(super) fn len_with(&self, more: usize) -> usize {
        (self.len() + more).min(self.capacity)
    }

    /// Returns whether there are no transitions.
    pub fn is_empty(&self) -> bool {
        self.transitions.is_empty()
    }

    /// Stores the first image of an episode and returns its number.
    pub fn begin_episode(&mut self, image: &Image) -> u64 {
        self.push_frame(Frame { image: *image.bytes(), before: None, tried: ActionSet::NONE })
    }

    /// Stores the transition caused by an action, from image number `state` to `next`, and returns
    /// the number of `next`.
    ///
    /// # Panics
    ///
    /// Panics if no image with the number `state` is stored.
    pub fn store(
        &mut self,
        state: u64,
        action: Action,
        reward: f32,
        terminated: bool,
        next: &Image,
    ) -> u64 {
        let back = (self.next_image - state) as u16;
        // Comparing views takes a few microseconds, which preset `paper` does not need to spend.
        let tried = match self.avoid_repetition {
            true => tried(
                next.bytes(),
                std::iter::once(action).chain(self.past(state).map_while(|moment| moment.action)),
                self.past(state),
            ),
            false => ActionSet::NONE,
        };
        let next_state =
            self.push_frame(Frame { image: *next.bytes(), before: Some((back, action)), tried });
        let transition = Transition { state, next_state, action, reward, terminated };
        if self.transitions.len() < self.capacity {
            self.transitions.push(transition);
        } else {
            self.transitions[self.oldest] = transition;
            self.oldest = (self.oldest + 1) % self.capacity;
        }
        next_state
    }

    /// Fills `batch` with the indices (see [`get`](ReplayMemory::get)) of distinct transitions,
    /// sampled uniformly. Returns false if there are too few transitions.
    ///
    /// The batch is sampled as if `more` further transitions had already been stored. This is
    /// possible because the indices depend only on the generator and the number of transitions.
    ///
    /// Uses an in-place version of Floyd's algorithm (Bentley, Programming Pearls, CACM 30(9),
    /// 1987).
    pub fn sample(&self, batch: &mut [usize], more: usize, random: &mut Random) -> bool {
        let length = self.len_with(more);
        let Some(first) = length.checked_sub(batch.len()) else {
            return false;
        };
        for place in 0..batch.len() {
            let last = first + place;
            let index = random.below(last + 1);
            // As in the rand crate, the order of the sample is not random.
            if let Some(duplicate) = batch[..place].iter_mut().find(|other| **other == index) {
                *duplicate = last;
            }
            batch[place] = index;
        }
        true
    }

    /// Returns whether one of the next `more` transitions will be stored at this index.
    pub fn is_among_next(&self, index: usize, more: usize) -> bool {
        (index + self.capacity - self.next_index()) % self.capacity < more
    }

    /// Returns the indices at which the next `more` transitions will be stored.
    pub fn next_indices(&self, more: usize) -> impl Iterator<Item = usize> + use<> {
        let (first, capacity) = (self.next_index(), self.capacity);
        (0..more).map(move |offset| (first + offset) % capacity)
    }

    /// Returns the index at which the next transition will be stored.
    fn next_index(&self) -> usize {
        if self.len() < self.capacity { self.len() } else { self.oldest }
    }

    /// Returns the transition at the given index.
    ///
    /// # Panics
    ///
    /// Panics if the index is not below [`len`](ReplayMemory::len).
    pub fn get(&self, index: usize) -> Transition {
        self.transitions[index]
    }

    /// Returns the index of the oldest transition.
    pub(super) fn oldest_index(&self) -> usize {
        self.oldest
    }

    /// Returns the maximum number of transitions.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Returns the image with the given number.
    ///
    /// # Panics
    ///
    /// Panics if no image with this number is stored.
    #[inline(always)]
    pub fn frame(&self, number: u64) -> &Frame {
        let index = (number - self.first_image) as usize;
        &self.images[index / CHUNK][index % CHUNK]
    }

    /// Iterates over the image with the given number and the earlier images of its episode, newest
    /// first.
    #[inline(always)]
    pub fn past(&self, number: u64) -> Past<'_> {
        Past { memory: self, number: Some(number) }
    }

    /// Loads the images of a batch into the processor's cache.
    ///
    /// The loads are independent, so their latencies overlap. Without this call, the images would
    /// be loaded one after another, each when it is converted.
    pub fn fetch(&self, batch: &[usize]) {
        const CACHE_LINE: usize = 64;
        let mut sum = 0u8;
        for index in batch {
            let transition = self.get(*index);
            // The state shares all of its images with the next state, except for the oldest one.
            let next = self.past(transition.next_state).take(self.frames);
            for moment in next.chain(self.past(transition.state).take(self.frames).last()) {
                let lines = moment.image.iter().step_by(CACHE_LINE);
                sum = lines.fold(sum, |sum, byte| sum.wrapping_add(*byte));
            }
        }
        std::hint::black_box(sum);
    }

    /// Iterates over the transitions, oldest first.
    pub fn oldest_first(&self) -> impl Iterator<Item = Transition> + '_ {
        let (newer, older) = self.transitions.split_at(self.oldest);
        older.iter().chain(newer).copied()
    }

    /// Returns the number of the next image to be stored.
    pub fn next_image(&self) -> u64 {
        self.next_image
    }

    /// Returns the numbers of the images that stored and future transitions may need.
    ///
    /// The environments take turns: between two consecutive images from one environment, each
    /// environment stores at most two images (the result of a step and the first image of a new
    /// episode). This limits how far back an observation reaches.
    pub fn needed_images(&self) -> std::ops::Range<u64> {
        let reach = self.reach();
        let oldest = self.oldest_first().next().map_or(self.next_image, |oldest| oldest.next_state);
        oldest.saturating_sub(reach).max(self.first_image)..self.next_image
    }

    /// Returns the maximum difference between the numbers of two consecutive images from the same
    /// environment.
    pub(super) fn most_between(&self) -> u32 {
        2 * self.environments as u32
    }

    /// Returns the maximum distance, in image numbers, from the next state of a transition back to
    /// the oldest image that its observations or [`tried`] need.
    fn reach(&self) -> u64 {
        (2 * self.environments * (self.frames.max(HORIZON) + 1)) as u64
    }

    fn push_frame(&mut self, frame: Frame) -> u64 {
        if self.images.back().is_none_or(|chunk| chunk.len() == CHUNK) {
            let needed = self.needed_images().start;
            let mut free = None;
            while self.first_image + CHUNK as u64 <= needed {
                free = self.images.pop_front();
                self.first_image += CHUNK as u64;
            }
            // The allocation is reused unless a clone of the replay memory shares it.
            let unshared = free.filter(|chunk| Arc::strong_count(chunk) == 1);
            let mut chunk = unshared.unwrap_or_default();
            let frames = Arc::make_mut(&mut chunk);
            frames.clear();
            frames.reserve_exact(CHUNK);
            self.images.push_back(chunk);
        }
        if let Some(chunk) = self.images.back_mut() {
            let frames = Arc::make_mut(chunk);
            // The copy of a shared chunk has no spare capacity.
            frames.reserve_exact(CHUNK - frames.len());
            frames.push(frame);
        }
        self.next_image += 1;
        self.next_image - 1
    }
}

/// The iterator returned by [`ReplayMemory::past`].
#[derive(Clone, Debug)]
pub struct Past<'a> {
    memory: &'a ReplayMemory,
    number: Option<u64>,
}

impl<'a> Iterator for Past<'a> {
    type Item = Moment<'a>;

    #[inline(always)]
    fn next(&mut self) -> Option<Moment<'a>> {
        let number = self.number?;
        let frame = self.memory.frame(number);
        self.number = frame
            .before
            .and_then(|(back, _)| number.checked_sub(back.into()))
            .filter(|number| *number >= self.memory.first_image);
        Some(Moment { image: &frame.image, action: frame.before.map(|(_, action)| action) })
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use proptest::prelude::*;

    use super::*;
    use crate::observation::History;

    fn image(number: usize) -> Image {
        let bytes: Vec<u8> = (0..Image::BYTES).map(|i| (number * 31 + i) as u8).collect();
        Image::try_from(bytes.as_slice()).unwrap()
    }

    proptest! {
        /// Compares the replay memory with a plain queue of whole images, over episodes of
        /// arbitrary length in several environments.
        #[test]
        fn behaves_like_a_queue_of_transitions(
            capacity in prop_oneof![1usize..40, 300usize..1000],
            environments in 1usize..4,
            frames in 1usize..5,
            lengths in prop::collection::vec(1usize..120, 1..60),
        ) {
            let mut memory = ReplayMemory::new(capacity, environments, frames, true);
            let mut model = VecDeque::new();
            let mut lengths = lengths.into_iter();
            let mut count = 0;
            let mut next_image = || {
                count += 1;
                image(count)
            };
            // For each environment: the number of steps left, the images so far, and the number of
            // the last image.
            let mut states: Vec<Option<(usize, Vec<Image>, u64)>> = vec![None; environments];
            let mut histories = vec![History::new(frames); environments];
            loop {
                for (state, history) in states.iter_mut().zip(&mut histories) {
                    if state.is_none() && let Some(length) = lengths.next() {
                        let first = next_image();
                        let number = memory.begin_episode(&first);
                        history.begin(first.clone());
                        *state = Some((length, vec![first], number));
                    }
                }
                if states.iter().all(Option::is_none) {
                    break;
                }
                let more = states.iter().flatten().count();
                let expected: Vec<bool> =
                    (0..capacity).map(|index| memory.is_among_next(index, more)).collect();
                let mut written = vec![false; capacity];
                for (state, history) in states.iter_mut().zip(&mut histories) {
                    let Some((left, mut images, number)) = state.take() else {
                        continue;
                    };
                    let action = Action::try_from((left % 7) as u8).unwrap();
                    // Some images repeat an earlier one or the previous one.
                    let next = match left % 5 {
                        0 => images[images.len() / 2].clone(),
                        1 => images[images.len() - 1].clone(),
                        _ => next_image(),
                    };
                    let terminated = left == 1;
                    let index = (0..capacity).find(|index| memory.is_among_next(*index, 1));
                    written[index.unwrap()] = true;
                    let number = memory.store(number, action, -0.1, terminated, &next);
                    history.push(action, next.clone());
                    prop_assert_eq!(memory.frame(number).tried, history.tried());
                    images.push(next);
                    model.push_back((images.clone(), action, terminated));
                    if model.len() > capacity {
                        model.pop_front();
                    }
                    if left > 1 {
                        *state = Some((left - 1, images, number));
                    }
                }
                prop_assert_eq!(written, expected);
            }
            prop_assert_eq!(memory.len(), model.len());
            let needed = memory.needed_images();
            let restored = ReplayMemory::new(capacity, environments, frames, true).restore(
                memory.oldest_first().collect(),
                memory.oldest_index(),
                needed.start,
                needed.clone().map(|number| *memory.frame(number)),
            );
            for number in needed {
                prop_assert_eq!(restored.frame(number), memory.frame(number));
            }
            let memory = restored;
            for (transition, (images, action, terminated)) in memory.oldest_first().zip(model) {
                let stored = |number: u64| memory.past(number).take(frames).map(|m| *m.image);
                let newest_first = || images.iter().rev().map(|image| *image.bytes());
                prop_assert!(stored(transition.next_state).eq(newest_first().take(frames)));
                prop_assert!(stored(transition.state).eq(newest_first().skip(1).take(frames)));
                prop_assert_eq!(transition.action, action);
                prop_assert_eq!(transition.terminated, terminated);
                prop_assert!(memory.needed_images().contains(&transition.state));
            }
        }
    }

    #[test]
    fn a_batch_samples_distinct_transitions_uniformly() {
        let mut memory = ReplayMemory::new(100, 1, 1, false);
        let mut state = memory.begin_episode(&image(0));
        for number in 1..=60 {
            state = memory.store(state, Action::try_from(0).unwrap(), -0.1, false, &image(number));
        }
        let mut random = Random::from_key([1; 4]);
        assert!(!memory.sample(&mut [0; 61], 0, &mut random));
        let mut counts = [0u32; 60];
        for _ in 0..6000 {
            let mut batch = [0; 20];
            assert!(memory.sample(&mut batch, 0, &mut random));
            assert_eq!(batch.iter().collect::<HashSet<_>>().len(), 20);
            batch.into_iter().for_each(|index| counts[index] += 1);
        }
        // The expected count is 2,000, with a standard deviation of 37.
        assert!(counts.iter().all(|count| (1800..2200).contains(count)), "{counts:?}");
    }
}
