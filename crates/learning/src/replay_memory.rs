//! The replay memory: a first-in-first-out queue of experiences (the paper's section 2.3).
//!
//! Consecutive experiences share an image, so images are stored once, as bytes, and an experience
//! points at two of them.

use std::{collections::VecDeque, sync::Arc};

use task::{Action, Image, Random};

use super::{
    greedy::ActionSet,
    observation::{HORIZON, Moment, tried},
};

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

/// An image, and how it came about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The bytes of the image.
    pub image: [u8; Image::BYTES],
    /// How far back the number of the image before it in the same episode is, and the action that
    /// led from there to here; none for the first of an episode.
    pub before: Option<(u16, Action)>,
    /// The actions that have been tried in the same episode from the same image.
    pub tried: ActionSet,
}

/// The memory: a ring of experiences, and the images that they need.
///
/// Images are numbered in the order of their coming, and kept in chunks; a chunk goes as soon as no
/// observation reaches back to it. A clone shares the chunks, so it costs next to nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplayMemory {
    capacity: usize,
    rooms: usize,
    /// How many images an observation holds.
    frames: usize,
    experiences: Vec<Experience>,
    /// Where the next experience goes once the memory is full.
    oldest: usize,
    /// Shared with those who have cloned the memory, until they differ.
    images: VecDeque<Arc<Vec<Frame>>>,
    /// The number of the first image that is kept.
    first_image: u64,
    /// The number of the next image.
    next_image: u64,
}

/// Images in a chunk.
const CHUNK: usize = 256;

impl ReplayMemory {
    /// An empty memory of at most `capacity` experiences, which come from so many rooms in turn, for
    /// observations of so many images.
    pub fn new(capacity: usize, rooms: usize, frames: usize) -> ReplayMemory {
        ReplayMemory {
            capacity,
            rooms,
            frames,
            experiences: Vec::new(),
            oldest: 0,
            images: VecDeque::new(),
            first_image: 0,
            next_image: 0,
        }
    }

    /// A memory as it was: its experiences from the oldest on, which has the index `oldest`; the
    /// images from number `first` on. Indices are what updates draw, so they must be the same.
    pub(super) fn restore(
        &self,
        mut experiences: Vec<Experience>,
        oldest: usize,
        first: u64,
        frames: impl Iterator<Item = Frame>,
    ) -> ReplayMemory {
        let mut memory = ReplayMemory::new(self.capacity, self.rooms, self.frames);
        (memory.first_image, memory.next_image) = (first, first);
        // Before the images: which of them are kept depends on the experiences.
        experiences.rotate_right(oldest);
        (memory.experiences, memory.oldest) = (experiences, oldest);
        for frame in frames {
            memory.push_frame(frame);
        }
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
        self.push_frame(Frame { image: *image.bytes(), before: None, tried: ActionSet::NONE })
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
        let back = (self.next_image - state) as u16;
        let tried = tried(
            next.bytes(),
            std::iter::once(action).chain(self.past(state).map_while(|moment| moment.action)),
            self.past(state),
        );
        let next_state =
            self.push_frame(Frame { image: *next.bytes(), before: Some((back, action)), tried });
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
    pub fn draw(&self, batch: &mut [usize], more: usize, random: &mut Random) -> bool {
        let length = (self.len() + more).min(self.capacity);
        let Some(first) = length.checked_sub(batch.len()) else {
            return false;
        };
        for place in 0..batch.len() {
            let last = first + place;
            let index = random.below(last + 1);
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

    /// How many experiences are kept at most.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// The image with a number that an experience holds.
    #[inline(always)]
    pub fn frame(&self, number: u64) -> &Frame {
        let index = (number - self.first_image) as usize;
        &self.images[index / CHUNK][index % CHUNK]
    }

    /// What was seen at a number, and before it in the same episode.
    #[inline(always)]
    pub fn past(&self, number: u64) -> Past<'_> {
        Past { memory: self, number: Some(number) }
    }

    /// Fetches the images of a batch from main memory, all at once, which takes the time of a few:
    /// when they are converted one after the other, each would have to be waited for.
    pub fn fetch(&self, batch: &[usize]) {
        const CACHE_LINE: usize = 64;
        let mut sum = 0u8;
        for index in batch {
            let experience = self.get(*index);
            // The state's own past is the next state's, but for the oldest of its images.
            let next = self.past(experience.next_state).take(self.frames);
            for moment in next.chain(self.past(experience.state).take(self.frames).last()) {
                let lines = moment.image.iter().step_by(CACHE_LINE);
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

    /// The numbers of the images that experiences, or the next ones, may need.
    ///
    /// The rooms take turns: between two images of one of them come at most two of each, its own and
    /// the first of another episode. So an observation reaches back by at most so many images.
    pub fn needed_images(&self) -> std::ops::Range<u64> {
        let reach = ReplayMemory::reach(self.rooms, self.frames);
        let oldest = self.oldest_first().next().map_or(self.next_image, |oldest| oldest.next_state);
        oldest.saturating_sub(reach).max(self.first_image)..self.next_image
    }

    /// How far apart the numbers of two images that follow each other in a room are at most.
    pub(super) fn most_between(&self) -> u32 {
        2 * self.rooms as u32
    }

    /// From the number of an experience's next state to that of the first image of its observation,
    /// at most.
    fn reach(rooms: usize, frames: usize) -> u64 {
        (2 * rooms * (frames.max(HORIZON) + 1)) as u64
    }

    fn push_frame(&mut self, frame: Frame) -> u64 {
        if self.images.back().is_none_or(|chunk| chunk.len() == CHUNK) {
            let needed = self.needed_images().start;
            let mut free = None;
            while self.first_image + CHUNK as u64 <= needed {
                free = self.images.pop_front();
                self.first_image += CHUNK as u64;
            }
            // Unless somebody else still has it, it is used again.
            let unshared = free.filter(|chunk| Arc::strong_count(chunk) == 1);
            let mut chunk = unshared.unwrap_or_default();
            let frames = Arc::make_mut(&mut chunk);
            frames.clear();
            frames.reserve_exact(CHUNK);
            self.images.push_back(chunk);
        }
        if let Some(chunk) = self.images.back_mut() {
            let frames = Arc::make_mut(chunk);
            // A clone of a shared chunk has no more room than it needs.
            frames.reserve_exact(CHUNK - frames.len());
            frames.push(frame);
        }
        self.next_image += 1;
        self.next_image - 1
    }
}

/// See [`ReplayMemory::past`].
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
        /// Against a plain queue of whole images, over episodes of any lengths in several rooms.
        #[test]
        fn it_is_a_queue_of_experiences(
            capacity in prop_oneof![1usize..40, 300usize..1000],
            rooms in 1usize..4,
            frames in 1usize..5,
            lengths in prop::collection::vec(1usize..120, 1..60),
        ) {
            let mut memory = ReplayMemory::new(capacity, rooms, frames);
            let mut model = VecDeque::new();
            let mut lengths = lengths.into_iter();
            let mut count = 0;
            let mut next_image = || {
                count += 1;
                image(count)
            };
            // The steps left, the images so far and the number of the last, in each room.
            let mut states: Vec<Option<(usize, Vec<Image>, u64)>> = vec![None; rooms];
            let mut histories = vec![History::new(frames); rooms];
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
                    // Some images come again: after a while, or at once.
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
            let restored = ReplayMemory::new(capacity, rooms, frames).restore(
                memory.oldest_first().collect(),
                memory.oldest_index(),
                needed.start,
                needed.clone().map(|number| *memory.frame(number)),
            );
            for number in needed {
                prop_assert_eq!(restored.frame(number), memory.frame(number));
            }
            let memory = restored;
            for (experience, (images, action, terminated)) in memory.oldest_first().zip(model) {
                let seen = |number: u64| memory.past(number).take(frames).map(|m| *m.image);
                let newest_first = || images.iter().rev().map(|image| *image.bytes());
                prop_assert!(seen(experience.next_state).eq(newest_first().take(frames)));
                prop_assert!(seen(experience.state).eq(newest_first().skip(1).take(frames)));
                prop_assert_eq!(experience.action, action);
                prop_assert_eq!(experience.terminated, terminated);
                prop_assert!(memory.needed_images().contains(&experience.state));
            }
        }
    }

    #[test]
    fn a_batch_is_of_different_memories_and_all_are_drawn_alike() {
        let mut memory = ReplayMemory::new(100, 1, 1);
        let mut state = memory.begin_episode(&image(0));
        for number in 1..=60 {
            state = memory.store(state, Action::try_from(0).unwrap(), -0.1, false, &image(number));
        }
        let mut random = Random::from_key([1; 4]);
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
