//! TensorBoard event files with the scalars of a training run.
//!
//! An event file is a sequence of TFRecords. Each consists of the length of the message, a checksum
//! of the length, the message, and a checksum of the message. The messages are defined in
//! TensorFlow's `event.proto` and `summary.proto` (protobuf); the types in this file have only
//! the fields that this module writes.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use crc::{CRC_32_ISCSI, Crc};
use prost::Message;

use learning::record::EpisodeRecord;

/// An open event file. The record of each episode contains these scalars:
///
/// | scalar | meaning |
/// |---|---|
/// | `charts/episodic_return` | undiscounted sum of rewards |
/// | `charts/episodic_length` | steps in the episode |
/// | `charts/epsilon` | exploration probability |
/// | `charts/blocked` | blocked moves in the episode |
/// | `charts/total_steps` | training steps so far |
/// | `losses/td_loss` | mean loss of the episode's updates; absent if there were none |
///
/// TensorBoard's step axis shows the episode, as in `episodes.csv` and in the figures of the paper.
/// Records are not buffered, so that TensorBoard can follow a training run live.
///
/// # Examples
///
/// ```no_run
/// use std::path::Path;
///
/// use learning::record::EpisodeRecord;
/// use report::TensorBoard;
///
/// let mut board = TensorBoard::create(Path::new("runs/empty/tensorboard"), 0)?;
/// let record = EpisodeRecord {
///     episode: 0,
///     steps: 40,
///     episode_return: -3.9,
///     epsilon: 1.0,
///     loss: None,
///     blocked: 2,
///     terminated: true,
/// };
/// board.record(&record, 40)?;
/// # Ok::<(), report::TensorBoardError>(())
/// ```
#[derive(Debug)]
pub struct TensorBoard {
    path: PathBuf,
    file: File,
}

/// The error returned if an event file cannot be created or written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write the TensorBoard event file {}", path.display())]
pub struct TensorBoardError {
    path: PathBuf,
    source: io::Error,
}

impl TensorBoard {
    /// Creates a new event file in `directory`, and the directory if it does not exist.
    ///
    /// `first_episode` is the episode at which the training run starts or resumes. In older
    /// event files in the same directory, TensorBoard then ignores the records of this episode and
    /// all later ones.
    ///
    /// # Errors
    ///
    /// Returns [`TensorBoardError`] if the directory or the file cannot be created or written.
    pub fn create(directory: &Path, first_episode: u32) -> Result<Self, TensorBoardError> {
        // TensorBoard requires "tfevents" in the name and reads the files in alphabetical order.
        let now = since_1970();
        let (seconds, nanoseconds) = (now.as_secs(), now.subsec_nanos());
        let name = format!("events.out.tfevents.{seconds:010}.{nanoseconds:09}.agent_node");
        let path = directory.join(name);
        let opened = std::fs::create_dir_all(directory).and_then(|()| File::create_new(&path));
        let file = opened.map_err(|source| TensorBoardError { path: path.clone(), source })?;

        let mut board = Self { path, file };
        board.write(&Event { file_version: Some("brain.Event:2".into()), ..Event::at(0) })?;
        let start = SessionLog { status: SESSION_START };
        board.write(&Event { session_log: Some(start), ..Event::at(first_episode) })?;
        Ok(board)
    }

    /// Writes the scalars of an episode. `total_steps` counts all steps since the start of the
    /// training run, including those of this episode.
    ///
    /// # Errors
    ///
    /// Returns [`TensorBoardError`] if the file cannot be written.
    pub fn record(
        &mut self,
        record: &EpisodeRecord,
        total_steps: u64,
    ) -> Result<(), TensorBoardError> {
        let scalars = [
            ("charts/episodic_return", Some(record.episode_return)),
            ("charts/episodic_length", Some(record.steps as f32)),
            ("charts/epsilon", Some(record.epsilon as f32)),
            ("charts/blocked", Some(record.blocked as f32)),
            ("charts/total_steps", Some(total_steps as f32)),
            ("losses/td_loss", record.loss.map(|loss| loss as f32)),
        ];
        let scalar = |(tag, value): (&str, Option<f32>)| {
            value.map(|value| Scalar { tag: tag.into(), simple_value: Some(value) })
        };
        let summary = Summary { values: scalars.into_iter().filter_map(scalar).collect() };
        self.write(&Event { summary: Some(summary), ..Event::at(record.episode) })
    }

    fn write(&mut self, event: &Event) -> Result<(), TensorBoardError> {
        let message = event.encode_to_vec();
        let length = (message.len() as u64).to_le_bytes();
        // One write per record, so that a concurrent reader does not see an incomplete record.
        let record = [
            &length[..],
            &masked_checksum(&length).to_le_bytes(),
            &message,
            &masked_checksum(&message).to_le_bytes(),
        ]
        .concat();
        let written = self.file.write_all(&record);
        written.map_err(|source| TensorBoardError { path: self.path.clone(), source })
    }
}

/// Returns the masked CRC-32C that TFRecords use. The mask keeps the checksum useful for data that
/// itself contains checksums.
fn masked_checksum(bytes: &[u8]) -> u32 {
    const CRC_32C: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);
    CRC_32C.checksum(bytes).rotate_right(15).wrapping_add(0xa282_ead8)
}

/// Returns the time since 1970-01-01 00:00 UTC, or zero if the clock is set to an earlier time.
fn since_1970() -> Duration {
    SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default()
}

/// `SessionLog.SessionStatus.START`.
const SESSION_START: i32 = 1;

/// `tensorflow.Event`. In TensorFlow, the optional fields are a `oneof`: exactly one is set.
#[derive(Clone, PartialEq, Message)]
struct Event {
    #[prost(double, tag = "1")]
    wall_time: f64,
    #[prost(int64, tag = "2")]
    step: i64,
    #[prost(string, optional, tag = "3")]
    file_version: Option<String>,
    #[prost(message, optional, tag = "5")]
    summary: Option<Summary>,
    #[prost(message, optional, tag = "7")]
    session_log: Option<SessionLog>,
}

impl Event {
    /// Returns an event with the current time and without content.
    fn at(episode: u32) -> Self {
        let (wall_time, step) = (since_1970().as_secs_f64(), episode.into());
        Self { wall_time, step, ..Self::default() }
    }
}

/// `tensorflow.Summary`.
#[derive(Clone, PartialEq, Message)]
struct Summary {
    #[prost(message, repeated, tag = "1")]
    values: Vec<Scalar>,
}

/// `tensorflow.Summary.Value` with a scalar.
#[derive(Clone, PartialEq, Message)]
struct Scalar {
    #[prost(string, tag = "1")]
    tag: String,
    /// Optional, because protobuf omits a plain field that is zero, and a value without this field
    /// is not a scalar.
    #[prost(float, optional, tag = "2")]
    simple_value: Option<f32>,
}

/// `tensorflow.SessionLog`.
#[derive(Clone, PartialEq, Message)]
struct SessionLog {
    #[prost(int32, tag = "1")]
    status: i32,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the messages of an event file, after checking lengths and checksums.
    fn read(path: &Path) -> Vec<Event> {
        let bytes = std::fs::read(path).unwrap();
        let mut rest = &bytes[..];
        let mut take = |count: usize| -> Option<&[u8]> { rest.split_off(..count) };
        let mut events = Vec::new();
        while let Some(length) = take(8) {
            assert_eq!(take(4).unwrap(), masked_checksum(length).to_le_bytes());
            let message = take(u64::from_le_bytes(length.try_into().unwrap()) as usize).unwrap();
            assert_eq!(take(4).unwrap(), masked_checksum(message).to_le_bytes());
            events.push(Event::decode(message).unwrap());
        }
        events
    }

    #[test]
    fn the_checksum_is_a_masked_crc_32c() {
        // CRC-32C of 32 zero bytes is 0x8a9136aa (RFC 3720, B.4).
        let masked = 0x8a91_36aa_u32.rotate_right(15).wrapping_add(0xa282_ead8);
        assert_eq!(masked_checksum(&[0; 32]), masked);
    }

    #[test]
    fn an_episode_is_one_record_with_all_scalars() {
        let directory = tempfile::tempdir().unwrap();
        let mut board = TensorBoard::create(&directory.path().join("run"), 5).unwrap();
        let mut record = EpisodeRecord {
            episode: 5,
            steps: 40,
            episode_return: -3.9,
            epsilon: 0.5,
            loss: None,
            blocked: 0,
            terminated: true,
        };
        board.record(&record, 1040).unwrap();
        record.loss = Some(0.25);
        board.record(&record, 1080).unwrap();

        let events = read(&board.path);
        assert_eq!(events[0].file_version.as_deref(), Some("brain.Event:2"));
        assert_eq!((events[1].step, &events[1].session_log), (5, &Some(SessionLog { status: 1 })));
        let scalars = |event: &Event| -> Vec<(String, f32)> {
            let values = event.summary.clone().unwrap().values;
            values.into_iter().map(|value| (value.tag, value.simple_value.unwrap())).collect()
        };
        assert_eq!(events[2].step, 5);
        assert_eq!(
            scalars(&events[2]),
            [
                ("charts/episodic_return".into(), -3.9),
                ("charts/episodic_length".into(), 40.0),
                ("charts/epsilon".into(), 0.5),
                ("charts/blocked".into(), 0.0),
                ("charts/total_steps".into(), 1040.0),
            ]
        );
        assert_eq!(scalars(&events[3]).last().unwrap(), &("losses/td_loss".into(), 0.25));
        assert_eq!(events.len(), 4);
    }
}
