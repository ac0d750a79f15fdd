//! Who is there: the readers of a topic, and the matches of each local endpoint, as DDS reports them.
//!
//! ros2-client's Spinner does the same, but with it comes a subscription to `/clock` of a wrong
//! type, so nobody here starts one.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use futures::StreamExt;
use parking_lot::Mutex;
use rustdds::{
    DomainParticipant, GUID,
    dds::statusevents::{DomainParticipantStatusEvent as Event, StatusEvented},
};
use tokio::sync::watch;

/// The matches of every local endpoint; a cheap handle that can be shared.
#[derive(Clone, Default)]
pub(crate) struct Graph {
    known: Arc<Mutex<Known>>,
}

#[derive(Default)]
struct Known {
    /// What each local endpoint is matched with.
    endpoints: BTreeMap<GUID, Endpoint>,
    /// The remote readers of each DDS topic.
    readers: BTreeMap<String, Endpoint>,
}

#[derive(Default)]
struct Endpoint {
    others: BTreeSet<GUID>,
    count: watch::Sender<usize>,
}

impl Graph {
    /// How many remote endpoints match a local one, now and from now on.
    pub(crate) fn matches(&self, local: GUID) -> watch::Receiver<usize> {
        self.with(|known| known.endpoints.entry(local).or_default().count.subscribe())
    }

    /// How many remote readers a DDS topic has, now and from now on.
    pub(crate) fn readers(&self, topic: &str) -> watch::Receiver<usize> {
        self.with(|known| known.readers.entry(topic.to_owned()).or_default().count.subscribe())
    }

    /// Whether a local endpoint has a match in another participant than those that read a DDS topic.
    pub(crate) fn matches_besides(&self, local: GUID, topic: &str) -> bool {
        self.with(|known| {
            let Some(endpoint) = known.endpoints.get(&local) else {
                return false;
            };
            let readers = known.readers.get(topic);
            let reads = |other: &GUID| {
                readers.is_some_and(|readers| {
                    readers.others.iter().any(|reader| reader.prefix == other.prefix)
                })
            };
            !endpoint.others.iter().all(reads)
        })
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
        self.with(|known| match event {
            Event::ReaderDetected { reader } => {
                let readers = known.readers.entry(reader.topic_name.clone()).or_default();
                readers.change(|others| others.insert(reader.guid));
            }
            Event::RemoteReaderMatched { local_writer: local, remote_reader: remote }
            | Event::RemoteWriterMatched { local_reader: local, remote_writer: remote } => {
                let endpoint = known.endpoints.entry(*local).or_default();
                endpoint.change(|others| others.insert(*remote));
            }
            Event::ReaderLost { guid, .. } | Event::WriterLost { guid, .. } => {
                known.all().for_each(|endpoint| endpoint.change(|others| others.remove(guid)));
            }
            // A process that was killed takes no leave: its endpoints go with its lease.
            Event::ParticipantLost { id, .. } => known.all().for_each(|endpoint| {
                endpoint.change(|others| {
                    let before = others.len();
                    others.retain(|guid| guid.prefix != *id);
                    others.len() != before
                });
            }),
            _ => {}
        });
    }

    fn with<T>(&self, work: impl FnOnce(&mut Known) -> T) -> T {
        work(&mut self.known.lock())
    }
}

impl Known {
    fn all(&mut self) -> impl Iterator<Item = &mut Endpoint> {
        self.endpoints.values_mut().chain(self.readers.values_mut())
    }
}

impl Endpoint {
    fn change(&mut self, change: impl FnOnce(&mut BTreeSet<GUID>) -> bool) {
        if change(&mut self.others) {
            self.count.send_replace(self.others.len());
        }
    }
}
