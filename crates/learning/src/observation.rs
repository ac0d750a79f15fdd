//! Observations: the robot's latest images and the actions between them.
//!
//! Training, evaluation and deployment share this code. As network input, an observation of
//! `frames` stacked images has the shape `[frames * 420 + (frames - 1) * 7]`: the bytes of each
//! image divided by 255, newest image first, then a one-hot vector for each action between two
//! images, newest action first. Entries from before the start of the episode are zero. With one
//! frame, this is the input used in the paper.

use std::collections::VecDeque;

use task::{Action, Image};

use super::{greedy::ActionSet, input::write_image};

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
/// assert_eq!(input_size(4), 4 * 420 + 3 * 7);
/// ```
pub fn input_size(frames: usize) -> usize {
    frames * Image::BYTES + frames.saturating_sub(1) * Action::COUNT
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
/// Panics if `input` is shorter than `frames * 420`.
#[inline(always)]
pub fn write_input<'a>(
    past: impl IntoIterator<Item = Moment<'a>>,
    frames: usize,
    augmentation: Augmentation,
    input: &mut [f32],
) {
    let (images, actions) = input.split_at_mut(frames * Image::BYTES);
    actions.fill(0.0);
    let mut past = past.into_iter();
    let mut actions = actions.chunks_exact_mut(Action::COUNT);
    let (images, _) = images.as_chunks_mut();
    for (index, input) in images.iter_mut().enumerate() {
        let Some(moment) = past.next().filter(|_| index < augmentation.frames) else {
            input.fill(0.0);
            continue;
        };
        match augmentation.mirrored {
            false => write_image(moment.image, input),
            true => write_image(&Image::mirrored(moment.image), input),
        }
        // The action is omitted if the preceding image is outside the augmented history.
        let led_here = moment.action.filter(|_| index + 1 < augmentation.frames);
        if let (Some(action), Some(one_hot)) = (led_here, actions.next()) {
            one_hot[usize::from(augmentation.action(action).index())] = 1.0;
        }
    }
}

/// Maximum number of past moments that [`tried`] examines.
pub const HORIZON: usize = 50;

/// Returns the actions that were already taken in response to an identical image within the last
/// [`HORIZON`] moments.
///
/// `past` yields the moments before `image`, and `actions` yields the action taken after each of
/// them, both newest first. The set never contains all actions: if all were taken, the one taken
/// longest ago is left out.
pub fn tried<'a>(
    image: &[u8; Image::BYTES],
    actions: impl Iterator<Item = Action>,
    past: impl Iterator<Item = Moment<'a>>,
) -> ActionSet {
    let identical = past.take(HORIZON).zip(actions).filter(|(moment, _)| moment.image == image);
    let mut tried = ActionSet::NONE;
    for (_, action) in identical {
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

    /// Returns the actions already taken in response to the current image (see [`tried`]).
    pub fn tried(&self) -> ActionSet {
        self.tried
    }
}
