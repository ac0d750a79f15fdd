//! Observations: the robot's latest images and the actions between them.
//!
//! Training, evaluation and deployment share this code. As network input, an observation of one
//! image has the shape `[420]`, the bytes of the image divided by 255, as in the paper. An
//! observation of several stacked images has the shape `[frames, 420 + 7]`, newest image first:
//! each row holds the bytes of an image divided by 255, and a one-hot vector for the action that
//! led to it. The action that led to the oldest image is omitted. Entries from before the start of
//! the episode are zero.

use std::collections::VecDeque;

use task::{Action, Image};

use super::{greedy::ActionSet, input::write_image, similarity::View};

/// An image of an episode, and the action that led to it.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a> {
    /// The bytes of the image, `[7, 20, 3]`.
    pub image: &'a [u8; Image::BYTES],
    /// The action that led to the image; `None` for the first image of an episode.
    pub action: Option<Action>,
}

/// Returns the number of network inputs for observations of `frames` stacked images.
///
/// # Examples
///
/// ```
/// use learning::observation::input_size;
///
/// assert_eq!(input_size(1), 420);
/// assert_eq!(input_size(4), 4 * (420 + 7));
/// ```
pub fn input_size(frames: usize) -> usize {
    frames * row_size(frames)
}

/// Returns the number of network inputs for each image in observations of `frames` stacked images.
fn row_size(frames: usize) -> usize {
    if frames > 1 { Image::BYTES + Action::COUNT } else { Image::BYTES }
}

/// A change made to observations and their actions: mirroring, a shorter history, or both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Augmentation {
    /// Whether images and actions are mirrored left to right.
    pub mirrored: bool,
    /// Maximum number of images; older entries are zero, as if the episode had started later.
    pub frames: usize,
}

impl Augmentation {
    /// No change.
    pub const NONE: Augmentation = Augmentation { mirrored: false, frames: usize::MAX };

    /// Returns the augmented action.
    pub fn action(self, action: Action) -> Action {
        if self.mirrored { action.mirrored() } else { action }
    }

    /// Returns the set of augmented actions.
    pub fn actions(self, actions: ActionSet) -> ActionSet {
        if self.mirrored { actions.mirrored() } else { actions }
    }
}

/// Writes an observation of `frames` stacked images as network input.
///
/// `past` yields the moments of the episode, newest first. `input` has the length
/// [`input_size(frames)`](input_size).
///
/// # Panics
///
/// May panic if `input` has a different length.
#[inline(always)]
pub fn write_input<'a>(
    past: impl IntoIterator<Item = Moment<'a>>,
    frames: usize,
    augmentation: Augmentation,
    input: &mut [f32],
) {
    let kept = augmentation.frames.min(frames);
    let mut past = past.into_iter().take(kept);
    for (index, row) in input.chunks_exact_mut(row_size(frames)).enumerate() {
        let (image, action) = row.split_first_chunk_mut().expect("a row contains an image");
        action.fill(0.0);
        let Some(moment) = past.next() else {
            image.fill(0.0);
            continue;
        };
        match augmentation.mirrored {
            false => write_image(moment.image, image),
            true => write_image(&Image::mirrored(moment.image), image),
        }
        // The action is omitted if the preceding image is not part of the observation.
        if let Some(led_here) = moment.action.filter(|_| index + 1 < kept) {
            action[usize::from(augmentation.action(led_here).index())] = 1.0;
        }
    }
}

/// Maximum number of past moments that [`tried`] examines.
pub const HORIZON: usize = 50;

/// Returns the actions that were already taken in response to the same view within the last
/// [`HORIZON`] moments. Two images show the same view if they differ by no more than the noise of
/// the camera ([`View`]).
///
/// `past` yields the moments before `image`, and `actions` yields the action taken after each of
/// them, both newest first. The set never contains all actions: if all were taken, the one taken
/// longest ago is left out.
pub fn tried<'a>(
    image: &[u8; Image::BYTES],
    actions: impl Iterator<Item = Action>,
    past: impl Iterator<Item = Moment<'a>>,
) -> ActionSet {
    let view = View::new(image);
    let repeated = past.take(HORIZON).zip(actions).filter(|(moment, _)| view.shows(moment.image));
    let mut tried = ActionSet::NONE;
    for (_, action) in repeated {
        let extended = tried.with(action);
        if extended == ActionSet::ALL {
            break;
        }
        tried = extended;
    }
    tried
}

/// The moments of the current episode that a policy needs.
#[derive(Clone, Debug)]
pub struct History {
    frames: usize,
    /// Newest first.
    moments: VecDeque<(Image, Option<Action>)>,
    tried: ActionSet,
}

impl History {
    /// Creates an empty history for observations of `frames` stacked images.
    pub fn new(frames: usize) -> History {
        History { frames, moments: VecDeque::new(), tried: ActionSet::NONE }
    }

    /// Starts an episode with its first image.
    pub fn begin(&mut self, image: Image) {
        self.moments.clear();
        self.moments.push_front((image, None));
        self.tried = ActionSet::NONE;
    }

    /// Adds the image that followed an action.
    pub fn push(&mut self, action: Action, image: Image) {
        let actions = std::iter::once(action).chain(self.past().map_while(|moment| moment.action));
        self.tried = tried(image.bytes(), actions, self.past());
        self.moments.truncate(self.frames.max(HORIZON));
        self.moments.push_front((image, Some(action)));
    }

    /// Iterates over the stored moments of the episode, newest first.
    pub fn past(&self) -> impl Iterator<Item = Moment<'_>> + Clone {
        self.moments.iter().map(|(image, action)| Moment { image: image.bytes(), action: *action })
    }

    /// Returns the actions already taken in response to the current view (see [`tried`]).
    pub fn tried(&self) -> ActionSet {
        self.tried
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blocked_move_is_recognized_although_no_two_images_are_identical() {
        let action = Action::try_from(2).expect("an action");
        let view = |level: usize, noise: usize| {
            let bytes: Vec<u8> =
                (0..Image::BYTES).map(|i| (level + (i * noise) % 7) as u8).collect();
            Image::try_from(bytes).expect("the size of an image")
        };
        let mut history = History::new(4);
        history.begin(view(100, 2));
        history.push(action, view(100, 3));
        assert_eq!(history.tried(), ActionSet::NONE.with(action));
        history.push(action, view(150, 4));
        assert_eq!(history.tried(), ActionSet::NONE);
        history.push(action, view(100, 5));
        assert_eq!(history.tried(), ActionSet::NONE.with(action));
    }
}
