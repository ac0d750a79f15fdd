//! The ROS graph: the remote readers of each topic and the matches of each local endpoint, as
//! reported by DDS.
//!
//! ros2-client's Spinner also tracks them, but it subscribes to `/clock` with the wrong type, so
//! this crate does not start a Spinner.

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

/// The readers and matches that DDS has reported. Clones share them.
#[derive(Clone, Default)]
pub(crate) struct Graph {
    state: Arc<Mutex<State>>,
}

#[derive(Default)]
struct State {
    /// The remote endpoints that match each local endpoint.
    matches: BTreeMap<GUID, Endpoints>,
    /// The remote readers of each DDS topic.
    readers: BTreeMap<String, Endpoints>,
}

/// A set of remote endpoints.
#[derive(Default)]
struct Endpoints {
    guids: BTreeSet<GUID>,
    count: watch::Sender<usize>,
}

impl Graph {
    /// Returns a receiver for the number of remote endpoints that match a local endpoint.
    pub(crate) fn matches(&self, local: GUID) -> watch::Receiver<usize> {
        self.with(|state| state.matches.entry(local).or_default().count.subscribe())
    }

    /// Returns a receiver for the number of remote readers of a DDS topic.
    pub(crate) fn readers(&self, topic: &str) -> watch::Receiver<usize> {
        self.with(|state| state.readers.entry(topic.to_owned()).or_default().count.subscribe())
    }

    /// Returns whether a local endpoint matches a remote endpoint in a participant that has no
    /// reader of the DDS topic `topic`.
    pub(crate) fn matches_besides(&self, local: GUID, topic: &str) -> bool {
        self.with(|state| {
            let Some(matches) = state.matches.get(&local) else {
                return false;
            };
            let readers = state.readers.get(topic);
            let is_of_a_reader = |guid: &GUID| {
                readers.is_some_and(|readers| {
                    readers.guids.iter().any(|reader| reader.prefix == guid.prefix)
                })
            };
            !matches.guids.iter().all(is_of_a_reader)
        })
    }

    /// Applies the participant's events until the task is dropped.
    pub(crate) async fn follow(self, participant: DomainParticipant) {
        let listener = participant.status_listener();
        let mut events = listener.as_async_status_stream();
        while let Some(event) = events.next().await {
            self.apply(&event);
        }
    }

    fn apply(&self, event: &Event) {
        self.with(|state| match event {
            Event::ReaderDetected { reader } => {
                let readers = state.readers.entry(reader.topic_name.clone()).or_default();
                readers.change(|guids| guids.insert(reader.guid));
            }
            Event::RemoteReaderMatched { local_writer: local, remote_reader: remote }
            | Event::RemoteWriterMatched { local_reader: local, remote_writer: remote } => {
                let matches = state.matches.entry(*local).or_default();
                matches.change(|guids| guids.insert(*remote));
            }
            Event::ReaderLost { guid, .. } | Event::WriterLost { guid, .. } => {
                state.all().for_each(|endpoints| endpoints.change(|guids| guids.remove(guid)));
            }
            // If a process was killed, its endpoints are not reported as lost individually.
            Event::ParticipantLost { id, .. } => state.all().for_each(|endpoints| {
                endpoints.change(|guids| {
                    let before = guids.len();
                    guids.retain(|guid| guid.prefix != *id);
                    guids.len() != before
                });
            }),
            _ => {}
        });
    }

    fn with<T>(&self, work: impl FnOnce(&mut State) -> T) -> T {
        work(&mut self.state.lock())
    }
}

impl State {
    fn all(&mut self) -> impl Iterator<Item = &mut Endpoints> {
        self.matches.values_mut().chain(self.readers.values_mut())
    }
}

impl Endpoints {
    /// Applies `change`, which returns whether it modified the set, and publishes the new count.
    fn change(&mut self, change: impl FnOnce(&mut BTreeSet<GUID>) -> bool) {
        if change(&mut self.guids) {
            self.count.send_replace(self.guids.len());
        }
    }
}
