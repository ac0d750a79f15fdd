//! Prioritized experience replay (Schaul, Quan, Antonoglou and Silver, 2016, proportional variant).
//!
//! A transition is sampled with a probability proportional to its priority, which is
//! `(|delta| + 0.01)^alpha`, where `delta` is the temporal-difference error of the transition in
//! the latest update that included it. Importance-sampling weights compensate for the bias that
//! this introduces.

use task::Random;

/// The priority of a transition that no update has included yet. It is higher than almost all others,
/// so new transitions are sampled soon.
const NEW: f32 = 1.0;

/// Added to each error, so that every transition can be sampled.
const LEAST_ERROR: f32 = 0.01;

/// The priorities of the transitions in a replay memory, by index.
///
/// They are the leaves of a binary tree in which each inner node holds the sum of its children, so
/// an update or a sample takes a number of operations proportional to the depth of the tree. All
/// sums depend only on the leaves, not on the order in which they were set.
///
/// # Examples
///
/// ```
/// use learning::priorities::Priorities;
/// use task::Random;
///
/// let mut priorities = Priorities::new(0.8);
/// (0..3).for_each(|index| priorities.announce(index));
/// priorities.set_error(0, 0.001);
/// priorities.set_error(1, 0.001);
/// let mut batch = [0; 100];
/// priorities.sample(&mut batch, &mut Random::from_key([1; 4]));
/// assert!(batch.iter().filter(|index| **index == 2).count() > 80);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Priorities {
    exponent: f32,
    leaves: usize,
    /// Node 1 is the root, the children of node `n` are `2 n` and `2 n + 1`, and the last `leaves`
    /// nodes are the leaves.
    sums: Vec<f64>,
}

impl Priorities {
    /// Creates priorities that are all 0: no transition can be sampled yet. `exponent` is alpha.
    pub fn new(exponent: f64) -> Priorities {
        Priorities { exponent: exponent as f32, leaves: 1, sums: vec![0.0; 2] }
    }

    /// Gives a transition the priority of a new one. `index` is its index in the replay memory, at
    /// which it may be stored later.
    pub fn announce(&mut self, index: usize) {
        self.set(index, NEW);
    }

    /// Sets the priority of a transition according to its temporal-difference error.
    pub fn set_error(&mut self, index: usize, error: f32) {
        self.set(index, libm::powf(error.abs() + LEAST_ERROR, self.exponent));
    }

    /// Sets the priority of a transition.
    pub(super) fn set(&mut self, index: usize, priority: f32) {
        while index >= self.leaves {
            self.grow();
        }
        let mut node = self.leaves + index;
        self.sums[node] = priority.into();
        while node > 1 {
            node /= 2;
            self.sums[node] = self.sums[2 * node] + self.sums[2 * node + 1];
        }
    }

    /// Doubles the number of leaves: the tree becomes the left half of a new one. No sum changes,
    /// because the new leaves are 0.
    fn grow(&mut self) {
        let mut sums = vec![0.0; 4 * self.leaves];
        // The nodes of each level are consecutive, and its first node is a power of 2.
        let mut level = 1;
        while level <= self.leaves {
            sums[2 * level..3 * level].copy_from_slice(&self.sums[level..2 * level]);
            level *= 2;
        }
        sums[1] = self.sums[1];
        (self.sums, self.leaves) = (sums, 2 * self.leaves);
    }

    /// Returns the priority of a transition; 0 if none was set.
    pub fn get(&self, index: usize) -> f32 {
        self.sums.get(self.leaves + index).map_or(0.0, |priority| *priority as f32)
    }

    /// Fills `batch` with the indices of transitions. The sum of all priorities is divided into
    /// equal ranges, one per sample, and each sample is drawn uniformly from its range. A
    /// transition may be sampled several times.
    pub fn sample(&self, batch: &mut [usize], random: &mut Random) {
        let range = self.sums[1] / batch.len() as f64;
        for (place, index) in batch.iter_mut().enumerate() {
            *index = self.find((place as f64 + random.uniform()) * range);
        }
    }

    /// Returns the index at which the running sum of the priorities exceeds `position`.
    fn find(&self, mut position: f64) -> usize {
        let mut node = 1;
        while node < self.leaves {
            node *= 2;
            // Rounding may leave a position at the end of the last range; the right child is then
            // empty.
            if position >= self.sums[node] && self.sums[node + 1] > 0.0 {
                position -= self.sums[node];
                node += 1;
            }
        }
        node - self.leaves
    }

    /// Writes the importance-sampling weights of a batch to `weights`: `(p_min / p)^beta`, where
    /// `p_min` is the lowest priority in the batch.
    pub fn importance_weights(&self, batch: &[usize], beta: f64, weights: &mut [f32]) {
        let priorities = || batch.iter().map(|index| self.get(*index));
        let lowest = priorities().fold(f32::INFINITY, f32::min);
        for (weight, priority) in weights.iter_mut().zip(priorities()) {
            *weight = libm::powf(lowest / priority, beta as f32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sums_depend_only_on_the_leaves(
            capacity in 1usize..70,
            errors in prop::collection::vec((0usize..70, 0f32..2.0), 1..200),
        ) {
            let mut priorities = Priorities::new(0.8);
            for (index, error) in errors {
                priorities.set_error(index % capacity, error);
            }
            let mut rebuilt = Priorities::new(0.8);
            for index in (0..priorities.leaves).rev() {
                rebuilt.set(index, priorities.get(index));
            }
            prop_assert_eq!(&rebuilt, &priorities);
            let mut batch = [0; 40];
            priorities.sample(&mut batch, &mut Random::from_key([2; 4]));
            prop_assert!(batch.iter().all(|index| priorities.get(*index) > 0.0));
        }
    }

    #[test]
    fn samples_are_proportional_to_the_priorities() {
        let mut priorities = Priorities::new(1.0);
        (0..5).for_each(|index| priorities.set(index, index as f32));
        let mut random = Random::from_key([1; 4]);
        let mut counts = [0u32; 5];
        for _ in 0..1000 {
            let mut batch = [0; 10];
            priorities.sample(&mut batch, &mut random);
            batch.into_iter().for_each(|index| counts[index] += 1);
        }
        for (index, count) in counts.into_iter().enumerate() {
            // Expected: a tenth of all samples for each unit of priority.
            let expected = 1000 * index as u32;
            assert!(count.abs_diff(expected) < 100, "{counts:?}");
        }
    }

    #[test]
    fn importance_weights_are_1_for_the_lowest_priority_and_cancel_priorities_at_beta_1() {
        let mut priorities = Priorities::new(0.8);
        [0.5, 1.0, 2.0].into_iter().enumerate().for_each(|(index, p)| priorities.set(index, p));
        let mut weights = [0.0; 4];
        priorities.importance_weights(&[2, 1, 2, 0], 1.0, &mut weights);
        assert_eq!(weights, [0.25, 0.5, 0.25, 1.0]);
        priorities.importance_weights(&[2, 1, 2, 0], 0.0, &mut weights);
        assert_eq!(weights, [1.0; 4]);
    }
}
