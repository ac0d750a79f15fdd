//! Reads the replay memory from a checkpoint.

use safetensors::Dtype;
use task::{Action, Image};

use super::{column::images_name, file::File};
use crate::{
    greedy::ActionSet,
    priorities::Priorities,
    replay_memory::{Frame, ReplayMemory, Transition},
};

/// Returns the replay memory stored in a file, with the same capacity, number of environments and
/// number of stacked images as `empty`.
///
/// `first_image` is the number of the first image in the file, and `oldest` is the index of the
/// oldest transition.
///
/// # Errors
///
/// Returns a description of the first inconsistency.
pub(super) fn memory(
    file: &File,
    empty: &ReplayMemory,
    first_image: u64,
    oldest: usize,
) -> Result<ReplayMemory, String> {
    let action = |index: u32| u8::try_from(index).ok().and_then(|a| Action::try_from(a).ok());
    let column = |name: &str| file.column(&format!("memory.{name}"));
    let mut images: Vec<&[u8; Image::BYTES]> = Vec::new();
    for chunk in (0..).map(images_name).map_while(|name| file.tensors.tensor(&name).ok()) {
        let (complete, rest) = chunk.data().as_chunks();
        if chunk.dtype() != Dtype::U8 || !rest.is_empty() {
            return Err("a memory.images tensor does not consist of whole images".into());
        }
        images.extend(complete);
    }
    let count = images.len();
    let [backs, actions, tried] = ["images.back", "images.action", "images.tried"].map(column);
    let (backs, actions, tried) = (backs?, actions?, tried?);
    if [&backs, &actions, &tried].iter().any(|column| column.len() != count) {
        return Err(format!("the memory.images tensors differ in length (expected: {count})"));
    }
    let mut frames = Vec::with_capacity(count);
    for (index, image) in images.iter().enumerate() {
        let back = u16::try_from(backs[index]).ok();
        let bits = u8::try_from(tried[index]).ok();
        let (Some(back), Some(action), Some(tried)) =
            (back, action(actions[index]), bits.and_then(ActionSet::from_bits))
        else {
            return Err(format!("image {index} has an invalid predecessor, action or action set"));
        };
        let before = (back > 0).then_some((back, action));
        frames.push(Frame { image: **image, before, tried });
    }
    let [states, next_states, actions, rewards, terminated] =
        ["state", "next_state", "action", "reward_bits", "terminated"].map(column);
    let (states, next_states, actions, rewards, terminated) =
        (states?, next_states?, actions?, rewards?, terminated?);
    let length = states.len();
    let columns = [&next_states, &actions, &rewards, &terminated];
    if length > empty.capacity() || columns.iter().any(|column| column.len() != length) {
        let capacity = empty.capacity();
        return Err(format!(
            "the replay memory has {length} transitions (expected: at most {capacity}, in tensors \
             of equal length)"
        ));
    }
    let mut transitions = Vec::with_capacity(length);
    for index in 0..length {
        let reward = f32::from_bits(rewards[index]);
        let (Some(action), true) = (action(actions[index]), reward.is_finite()) else {
            return Err(format!("transition {index} has an invalid action or reward"));
        };
        let (state, next_state) = (states[index], next_states[index]);
        let in_order = index == 0 || next_state > next_states[index - 1];
        let is_near = next_state.saturating_sub(state) <= empty.most_between();
        if next_state as usize >= count || state >= next_state || !in_order || !is_near {
            return Err(format!("transition {index} has an invalid image reference"));
        }
        transitions.push(Transition {
            state: first_image + u64::from(states[index]),
            next_state: first_image + u64::from(next_states[index]),
            action,
            reward,
            terminated: terminated[index] != 0,
        });
    }
    // Until the replay memory is full, the oldest transition has index 0.
    if oldest != 0 && (length < empty.capacity() || oldest >= length) {
        return Err(format!("invalid oldest transition: {oldest} (with {length} transitions)"));
    }
    Ok(empty.restore(transitions, oldest, first_image, frames.into_iter()))
}

/// Reads the priorities of `count` transitions, in the order of their indices.
///
/// # Errors
///
/// Returns a description of the first inconsistency.
pub(super) fn read_priorities(
    file: &File,
    count: usize,
    priorities: &mut Priorities,
) -> Result<(), String> {
    let bits = file.column("memory.priority_bits")?;
    if bits.len() != count {
        return Err(format!("there are {} priorities (expected: {count})", bits.len()));
    }
    for (index, bits) in bits.into_iter().enumerate() {
        let priority = f32::from_bits(bits);
        if !priority.is_finite() || priority <= 0.0 {
            return Err(format!("priority {index} is {priority} (expected: a positive number)"));
        }
        priorities.set(index, priority);
    }
    Ok(())
}
