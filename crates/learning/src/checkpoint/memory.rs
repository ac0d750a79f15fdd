//! The replay memory, from a checkpoint.

use safetensors::Dtype;
use task::{Action, Image};

use super::{column::images_name, file::File};
use crate::{
    greedy::ActionSet,
    replay_memory::{Experience, Frame, ReplayMemory},
};

/// The memory that the file holds, of the form of an empty one.
pub(super) fn memory(
    file: &File,
    empty: &ReplayMemory,
    first_image: u64,
    oldest: usize,
) -> Result<ReplayMemory, String> {
    let action = |index: u32| u8::try_from(index).ok().and_then(|a| Action::try_from(a).ok());
    let column = |name: &str| file.column(&format!("memory.{name}"));
    let mut images: Vec<&[u8; Image::BYTES]> = Vec::new();
    for piece in (0..).map(images_name).map_while(|name| file.tensors.tensor(&name).ok()) {
        let (whole, rest) = piece.data().as_chunks();
        if piece.dtype() != Dtype::U8 || !rest.is_empty() {
            return Err("a piece of memory.images holds something else than images".into());
        }
        images.extend(whole);
    }
    let count = images.len();
    let [backs, actions, tried] = ["images.back", "images.action", "images.tried"].map(column);
    let (backs, actions, tried) = (backs?, actions?, tried?);
    if [&backs, &actions, &tried].iter().any(|column| column.len() != count) {
        return Err("columns of images are unequal".into());
    }
    let mut frames = Vec::with_capacity(count);
    for (index, image) in images.iter().enumerate() {
        let back = u16::try_from(backs[index]).ok();
        let bits = u8::try_from(tried[index]).ok();
        let (Some(back), Some(action), Some(tried)) =
            (back, action(actions[index]), bits.and_then(ActionSet::from_bits))
        else {
            return Err(format!("image {index} has come about in a way that is not possible"));
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
        return Err(format!("a memory of {length} experiences, or of unequal columns"));
    }
    let mut experiences = Vec::with_capacity(length);
    for index in 0..length {
        let reward = f32::from_bits(rewards[index]);
        let (Some(action), true) = (action(actions[index]), reward.is_finite()) else {
            return Err(format!("experience {index} has a wrong action or reward"));
        };
        let (state, next_state) = (states[index], next_states[index]);
        let in_order = index == 0 || next_state > next_states[index - 1];
        let is_near = next_state.saturating_sub(state) <= empty.most_between();
        if next_state as usize >= count || state >= next_state || !in_order || !is_near {
            return Err(format!("experience {index} points at an image that is not its own"));
        }
        experiences.push(Experience {
            state: first_image + u64::from(states[index]),
            next_state: first_image + u64::from(next_states[index]),
            action,
            reward,
            terminated: terminated[index] != 0,
        });
    }
    // Until the memory is full, the oldest experience is the first.
    if oldest != 0 && (length < empty.capacity() || oldest >= length) {
        return Err(format!("the oldest of {length} experiences cannot have the index {oldest}"));
    }
    Ok(empty.restore(experiences, oldest, first_image, frames.into_iter()))
}
