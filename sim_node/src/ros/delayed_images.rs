//! Images on their way from the camera to the topic.

use std::collections::VecDeque;

use ros_interfaces::sensor_msgs::Image;
use tokio::time::Instant;

/// Images that are published later than they were taken, in the order in which they were taken.
#[derive(Default)]
pub(super) struct DelayedImages {
    images: VecDeque<(Instant, Image)>,
}

impl DelayedImages {
    /// Adds an image that is due at `due`, or together with the latest one if that is due later.
    pub(super) fn push(&mut self, due: Instant, image: Image) {
        let due = self.images.back().map_or(due, |(latest, _)| due.max(*latest));
        self.images.push_back((due, image));
    }

    /// Returns when the next image is due, if there is one.
    pub(super) fn due(&self) -> Option<Instant> {
        self.images.front().map(|(due, _)| *due)
    }

    /// Returns the next image if it is due.
    pub(super) fn pop(&mut self, now: Instant) -> Option<Image> {
        let (_, image) = self.images.pop_front_if(|(due, _)| *due <= now)?;
        Some(image)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn images_stay_in_order_if_the_latency_falls() {
        let start = Instant::now();
        let at = |milliseconds| start + Duration::from_millis(milliseconds);
        let image = |width| Image { width, ..Image::default() };
        let mut delayed = DelayedImages::default();
        assert_eq!(delayed.due(), None);
        delayed.push(at(100), image(1));
        delayed.push(at(50), image(2));
        assert_eq!((delayed.due(), delayed.pop(at(99))), (Some(at(100)), None));
        assert_eq!(delayed.pop(at(100)), Some(image(1)));
        assert_eq!(delayed.pop(at(100)), Some(image(2)));
        assert_eq!(delayed.pop(at(200)), None);
    }
}
