//! Who is connected to whom: the matches that DDS reports, counted per local endpoint.
//!
//! ros2-client's Spinner does the same, but with it comes a subscription to `/clock` of a wrong
//! type, so nobody here starts one.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::{Arc, Mutex},
};

use futures::StreamExt;
use rustdds::{
    DomainParticipant, GUID,
    dds::statusevents::{DomainParticipantStatusEvent as Event, StatusEvented},
};
use tokio::sync::watch;

/// The matches of every local endpoint; a cheap handle that can be shared.
#[derive(Clone, Default)]
pub(crate) struct Graph {
    endpoints: Arc<Mutex<BTreeMap<GUID, Endpoint>>>,
}

#[derive(Default)]
struct Endpoint {
    matched: BTreeSet<GUID>,
    count: watch::Sender<usize>,
}

impl Graph {
    /// How many remote endpoints match a local one, now and from now on.
    pub(crate) fn matches(&self, local: GUID) -> watch::Receiver<usize> {
        self.with(|endpoints| endpoints.entry(local).or_default().count.subscribe())
    }

    /// Follows the participant's events for ever.
    pub(crate) async fn follow(self, participant: DomainParticipant) {
        let listener = participant.status_listener();
        let mut events = listener.as_async_status_stream();
        while let Some(event) = events.next().await {
            self.apply(&event);
        }
    }

    fn apply(&self, event: &Event) {
        self.with(|endpoints| match event {
            Event::RemoteReaderMatched { local_writer: local, remote_reader: remote }
            | Event::RemoteWriterMatched { local_reader: local, remote_writer: remote } => {
                let endpoint = endpoints.entry(*local).or_default();
                endpoint.change(|matched| matched.insert(*remote));
            }
            Event::ReaderLost { guid, .. } | Event::WriterLost { guid, .. } => {
                endpoints.values_mut().for_each(|e| e.change(|matched| matched.remove(guid)));
            }
            // A process that was killed takes no leave: its endpoints go with its lease.
            Event::ParticipantLost { id, .. } => endpoints.values_mut().for_each(|endpoint| {
                endpoint.change(|matched| {
                    let before = matched.len();
                    matched.retain(|guid| guid.prefix != *id);
                    matched.len() != before
                });
            }),
            _ => {}
        });
    }

    fn with<T>(&self, work: impl FnOnce(&mut BTreeMap<GUID, Endpoint>) -> T) -> T {
        work(&mut self.endpoints.lock().expect("nothing panics while it holds this lock"))
    }
}

impl Endpoint {
    fn change(&mut self, change: impl FnOnce(&mut BTreeSet<GUID>) -> bool) {
        if change(&mut self.matched) {
            self.count.send_replace(self.matched.len());
        }
    }
}
