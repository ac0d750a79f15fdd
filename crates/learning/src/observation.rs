//! What a policy sees: the robot's last images, and its own actions between them.
//!
//! Training, test and deployment build it here. As a network's input it is, newest first, the bytes
//! of each image divided by 255, then for each action between two of them a 1 at its index among
//! seven zeros; what lies before the episode's first image is zero. With one image this is the
//! paper's input.

use std::collections::VecDeque;

use task::{Action, Image};

use super::input::write_image;

use super::greedy::ActionSet;

/// An image, and how it came about.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a> {
    /// The bytes of the image.
    pub image: &'a [u8; Image::BYTES],
    /// The action that led to it; none for the first of an episode.
    pub action: Option<Action>,
}

/// Inputs of a network that sees so many images.
pub fn input_size(frames: usize) -> usize {
    frames * Image::BYTES + frames.saturating_sub(1) * Action::COUNT
}

/// How an observation is looked at. Training takes some of its memories as others could have been.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct View {
    /// Left and right are exchanged.
    pub mirrored: bool,
    /// At most so many images are seen; those before are as before the start of an episode.
    pub frames: usize,
}

impl View {
    /// As it is.
    pub const PLAIN: View = View { mirrored: false, frames: usize::MAX };

    /// What an action is in this view.
    pub fn action(self, action: Action) -> Action {
        if self.mirrored { action.mirrored() } else { action }
    }

    /// What some actions are in this view.
    pub fn actions(self, actions: ActionSet) -> ActionSet {
        if self.mirrored { actions.mirrored() } else { actions }
    }
}

/// Writes an observation of so many images, given the present moment and those before it.
#[inline(always)]
pub fn write_input<'a>(
    past: impl IntoIterator<Item = Moment<'a>>,
    frames: usize,
    view: View,
    input: &mut [f32],
) {
    let (images, actions) = input.split_at_mut(frames * Image::BYTES);
    actions.fill(0.0);
    let mut past = past.into_iter();
    let mut actions = actions.chunks_exact_mut(Action::COUNT);
    let (images, _) = images.as_chunks_mut();
    for (index, input) in images.iter_mut().enumerate() {
        let Some(moment) = past.next().filter(|_| index < view.frames) else {
            input.fill(0.0);
            continue;
        };
        match view.mirrored {
            false => write_image(moment.image, input),
            true => write_image(&Image::mirrored(moment.image), input),
        }
        // The action before the oldest image that is seen leads to it from nowhere.
        let led_here = moment.action.filter(|_| index + 1 < view.frames);
        if let (Some(action), Some(one_hot)) = (led_here, actions.next()) {
            one_hot[usize::from(view.action(action).index())] = 1.0;
        }
    }
}

/// How many moments back a policy remembers what it has tried.
pub const HORIZON: usize = 50;

/// The actions that were taken last where the same image was seen, within the [`HORIZON`]. Where that
/// would be all of them, the one that was taken longest ago is not among them. Given the present
/// image, the moments before it, and the actions that they were left by, newest first.
pub fn tried<'a>(
    image: &[u8; Image::BYTES],
    actions: impl Iterator<Item = Action>,
    past: impl Iterator<Item = Moment<'a>>,
) -> ActionSet {
    let same = past.take(HORIZON).zip(actions).filter(|(moment, _)| moment.image == image);
    let mut tried = ActionSet::NONE;
    for (_, action) in same {
        let more = tried.with(action);
        if more == ActionSet::ALL {
            break;
        }
        tried = more;
    }
    tried
}

/// The present episode as far as a policy remembers it.
#[derive(Clone, Debug)]
pub struct History {
    frames: usize,
    /// The newest first.
    moments: VecDeque<(Image, Option<Action>)>,
    tried: ActionSet,
}

impl History {
    /// Nothing yet; so many images will be remembered.
    pub fn new(frames: usize) -> History {
        History { frames, moments: VecDeque::new(), tried: ActionSet::NONE }
    }

    /// The first image of an episode.
    pub fn begin(&mut self, image: Image) {
        self.moments.clear();
        self.moments.push_front((image, None));
        self.tried = ActionSet::NONE;
    }

    /// The image that an action led to.
    pub fn push(&mut self, action: Action, image: Image) {
        let actions = std::iter::once(action).chain(self.past().map_while(|moment| moment.action));
        self.tried = tried(image.bytes(), actions, self.past());
        self.moments.truncate(self.frames.max(HORIZON));
        self.moments.push_front((image, Some(action)));
    }

    /// The present moment and those before it.
    pub fn past(&self) -> impl Iterator<Item = Moment<'_>> + Clone {
        self.moments.iter().map(|(image, action)| Moment { image: image.bytes(), action: *action })
    }

    /// As [`tried`].
    pub fn tried(&self) -> ActionSet {
        self.tried
    }
}
