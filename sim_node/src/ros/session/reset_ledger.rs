//! Which resets were answered, and how, so that one that is asked for again resets nothing.

use std::{collections::VecDeque, num::NonZeroU32};

use evac_msgs::reset;

use super::ClientId;

/// The maximum number of clients whose latest reset is stored; the oldest is dropped first.
pub(super) const NUMBERINGS: usize = 64;

/// Who has numbered resets, and the latest number of each.
#[derive(Clone, Default)]
pub(super) struct ResetLedger {
    numberings: VecDeque<(Numbering, u64)>,
    latest: Option<LatestReset>,
}

/// Whose numbers those of a reset are.
#[derive(Clone, Copy, PartialEq)]
enum Numbering {
    /// Small numbers are the client's own.
    Client(ClientId),
    /// A program draws the upper half of its numbers. It may have to ask again by a new client, and is
    /// still the same to the room.
    Drawn(NonZeroU32),
}

#[derive(Clone)]
struct LatestReset {
    numbering: Numbering,
    request: reset::Request,
    response: reset::Response,
}

impl ResetLedger {
    /// How many clients are remembered.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.numberings.len()
    }

    /// The stored answer to a reset that was executed before, or why it cannot be given; none to one
    /// that is new. `steps` is how many the episode has taken.
    pub(super) fn answered(
        &self,
        client: ClientId,
        request: &reset::Request,
        steps: u32,
    ) -> Option<Result<reset::Response, String>> {
        if request.request == 0 {
            return None;
        }
        let numbering = Numbering::of(client, request.request);
        if let Some(latest) = &self.latest {
            // By hand each call is a client of its own: there the whole request must be the same, and
            // nothing have happened since.
            let same_number =
                latest.numbering == numbering && latest.request.request == request.request;
            let by_hand = latest.request == *request && steps == 0;
            if same_number || by_hand {
                return Some(Ok(latest.response.clone()));
            }
        }
        let (_, latest) = self.numberings.iter().find(|(known, _)| *known == numbering)?;
        let number = request.request;
        (number <= *latest).then(|| {
            Err(match number == *latest {
                true => format!("another client has reset the room since your request {number}"),
                false => format!("request {number} is older than your latest, {latest}"),
            })
        })
    }

    /// Notes what was answered to a reset that was executed.
    pub(super) fn note(
        &mut self,
        client: ClientId,
        request: &reset::Request,
        response: &reset::Response,
    ) {
        self.latest = None;
        if request.request != 0 {
            let numbering = Numbering::of(client, request.request);
            self.numberings.retain(|(known, _)| *known != numbering);
            self.numberings.push_back((numbering, request.request));
            if self.numberings.len() > NUMBERINGS {
                self.numberings.pop_front();
            }
            let (request, response) = (request.clone(), response.clone());
            self.latest = Some(LatestReset { numbering, request, response });
        }
    }
}

impl Numbering {
    fn of(client: ClientId, request: u64) -> Numbering {
        upper_half(request).map_or(Numbering::Client(client), Numbering::Drawn)
    }
}

/// Who has given a number, if that is one who draws the upper half.
pub(super) fn upper_half(number: u64) -> Option<NonZeroU32> {
    NonZeroU32::new((number >> 32) as u32)
}
