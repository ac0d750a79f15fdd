//! Stores the response to the latest reset, so that a retry does not reset the environment again.

use std::{collections::VecDeque, num::NonZeroU32};

use evac_msgs::reset;

/// The GUID of a client's DDS request writer.
pub type ClientId = [u8; 16];

/// Maximum number of senders whose latest request number is stored. The sender whose latest reset
/// is oldest is dropped first.
pub(super) const MAX_SENDERS: usize = 64;

/// The latest request number of each sender, and the response to the latest reset.
#[derive(Clone, Default)]
pub(super) struct ResetLedger {
    senders: VecDeque<(Sender, u64)>,
    latest: Option<LatestReset>,
}

/// The sender of a reset, which assigns the request numbers.
#[derive(Clone, Copy, PartialEq)]
enum Sender {
    /// A DDS client; its request numbers are below 2^32.
    Client(ClientId),
    /// A program, identified by the upper 32 bits of its request numbers, which it draws at random.
    /// It may retry through another client.
    Program(NonZeroU32),
}

#[derive(Clone)]
struct LatestReset {
    sender: Sender,
    request: reset::Request,
    response: reset::Response,
}

impl ResetLedger {
    /// Returns the number of stored senders.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.senders.len()
    }

    /// Returns the stored response if the request is a retry of the latest reset, an error message
    /// if it is superseded or out of order, and `None` if it is new.
    ///
    /// `steps` is the number of steps executed in the current episode.
    pub(super) fn stored_response(
        &self,
        client: ClientId,
        request: &reset::Request,
        steps: u32,
    ) -> Option<Result<reset::Response, String>> {
        if request.request == 0 {
            return None;
        }
        let sender = Sender::new(client, request.request);
        if let Some(latest) = &self.latest {
            let same_number = latest.sender == sender && latest.request.request == request.request;
            // Command-line tools create a client for each call. An identical request from another
            // client therefore counts as a retry until the episode has its first step.
            let is_manual_retry = latest.request == *request && steps == 0;
            if same_number || is_manual_retry {
                return Some(Ok(latest.response.clone()));
            }
        }
        let (_, latest) = self.senders.iter().find(|(known, _)| *known == sender)?;
        let number = request.request;
        (number <= *latest).then(|| {
            Err(match number == *latest {
                true => format!("request {number} was superseded by a reset from another client"),
                false => format!("request {number} is out of order: the latest is {latest}"),
            })
        })
    }

    /// Stores the response to an executed reset.
    pub(super) fn store(
        &mut self,
        client: ClientId,
        request: &reset::Request,
        response: &reset::Response,
    ) {
        self.latest = None;
        if request.request != 0 {
            let sender = Sender::new(client, request.request);
            self.senders.retain(|(known, _)| *known != sender);
            self.senders.push_back((sender, request.request));
            if self.senders.len() > MAX_SENDERS {
                self.senders.pop_front();
            }
            let (request, response) = (request.clone(), response.clone());
            self.latest = Some(LatestReset { sender, request, response });
        }
    }
}

impl Sender {
    fn new(client: ClientId, request: u64) -> Sender {
        upper_half(request).map_or(Sender::Client(client), Sender::Program)
    }
}

/// Returns the upper 32 bits of a number, which identify a program or a run of the simulator;
/// `None` if they are 0.
pub(super) fn upper_half(number: u64) -> Option<NonZeroU32> {
    NonZeroU32::new((number >> 32) as u32)
}
