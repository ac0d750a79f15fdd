use super::*;
use crate::record::EpisodeRecord;
use crate::settings::Preset;

fn plan() -> Plan {
    Plan { scenario: "empty".into(), episodes: 10, seed: 3, rooms: 2 }
}

fn bytes_of(training: &Training) -> Vec<u8> {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("checkpoint.safetensors");
    training.write_checkpoint(&file).unwrap();
    std::fs::read(file).unwrap()
}

fn load(bytes: &[u8], plan: Plan, settings: Settings) -> Result<Training, String> {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("checkpoint.safetensors");
    std::fs::write(&file, bytes).unwrap();
    Training::load(&file, plan, settings).map_err(|error| error.to_string())
}

/// Replaces text in the state stored in a file and updates the checksum.
fn with_state(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    let (length, rest) = bytes.split_at(8);
    let length = u64::from_le_bytes(length.try_into().unwrap()) as usize;
    let (header, tensors) = rest.split_at(length);
    // The state is a JSON string inside the JSON header.
    let escaped = |text: &str| text.replace('"', "\\\"");
    let header = std::str::from_utf8(header).unwrap();
    assert!(header.contains(&escaped(from)), "no {from} in the checkpoint");
    let header = header.replace(&escaped(from), &escaped(to));
    let length = (header.len() as u64).to_le_bytes();
    with_valid_checksum(&[&length, header.as_bytes(), tensors].concat())
}

/// Returns a copy of a checkpoint's bytes with a valid checksum.
fn with_valid_checksum(bytes: &[u8]) -> Vec<u8> {
    let file = File::parse(Path::new("test"), bytes).unwrap();
    let (written, state) = file.metadata[METADATA_KEY].split_once(' ').unwrap();
    let mut views: Vec<_> = file.tensors.iter().collect();
    views.sort_by_key(|(name, _)| *name);
    let valid = checksum(state, views.iter().map(|(name, view)| (*name, view)));
    let valid = format!("{valid:08x}");
    let position = bytes.windows(8).position(|window| window == written.as_bytes()).unwrap();
    let mut bytes = bytes.to_vec();
    bytes[position..position + 8].copy_from_slice(valid.as_bytes());
    bytes
}

/// Flips one bit at a time, at 300 positions.
#[test]
fn detects_a_flipped_bit_anywhere() {
    let settings = Preset::Paper.settings();
    let bytes = bytes_of(&Training::new(plan(), settings.clone()).unwrap());
    let step = bytes.len() / 300;
    for position in (0..bytes.len()).step_by(step) {
        let mut damaged = bytes.clone();
        damaged[position] ^= 1 << (position % 8);
        let Err(message) = load(&damaged, plan(), settings.clone()) else {
            panic!("a flipped bit in byte {position} was accepted");
        };
        assert!(message.contains("checkpoint.safetensors"), "{message}");
    }
}

#[test]
fn rejects_a_checkpoint_of_another_run_and_names_the_difference() {
    let settings = Preset::Paper.settings();
    let bytes = bytes_of(&Training::new(plan(), settings.clone()).unwrap());
    assert!(load(&bytes, plan(), settings.clone()).is_ok());
    let message = |plan, settings| load(&bytes, plan, settings).unwrap_err();
    let other = Plan { seed: 4, ..plan() };
    assert!(
        message(other, settings.clone())
            .ends_with("does not match this run: its seed is 3 (expected: 4)")
    );
    let other = Plan { rooms: 3, ..plan() };
    let text = message(other, settings.clone());
    assert!(text.ends_with("its number of simulators is 2 (expected: 3)"), "{text}");
    let other = settings.with(|s| {
        s.target.discount = 0.9;
        s.replay.batch_size = 32;
    });
    let message = message(plan(), other);
    assert!(message.contains("its replay.batch_size is 50 (expected: 32)"), "{message}");
    assert!(message.contains("its target.discount is 0.999 (expected: 0.9)"), "{message}");
}

#[test]
fn rejects_invalid_states_and_truncated_files() {
    let settings = Preset::Paper.settings();
    let bytes = bytes_of(&Training::new(plan(), settings.clone()).unwrap());
    assert!(load(&with_state(&bytes, "empty", "empty"), plan(), settings.clone()).is_ok());
    let version = format!(r#""version":{VERSION}"#);
    for (from, to) in [
        (r#""wall":{"secs":0"#, r#""wall":{"secs":18446744073709551615"#),
        (r#""first_image":0"#, r#""first_image":18446744073709551000"#),
        (r#""first_image":0"#, r#""first_image":x"#),
        (r#""total_steps":0"#, r#""total_steps":18446744073709551000"#),
        (r#""adam_step":0"#, r#""adam_step":7"#),
        (r#""rooms":2"#, r#""rooms":3"#),
        (r#""next_episode":2"#, r#""next_episode":3"#),
        (r#""episode":1,"image":null"#, r#""episode":2,"image":null"#),
        (r#""episode":1,"image":null"#, r#""episode":1,"image":0"#),
        (r#""begun":null"#, r#""begun":{"actions":[1],"updates":0}"#),
        (version.as_str(), r#""version":2"#),
        (r#""replay_position":"0""#, r#""replay_position":"y""#),
    ] {
        let result = load(&with_state(&bytes, from, to), plan(), settings.clone());
        assert!(result.is_err(), "{to} was accepted");
    }
    for cut in [0, 7, 8, 100, bytes.len() / 2, bytes.len() - 1] {
        assert!(load(&bytes[..cut], plan(), settings.clone()).is_err(), "accepted {cut} bytes");
    }
}

#[test]
fn restores_the_records_of_a_long_run_in_order() {
    let (plan, settings) = (Plan { episodes: 5000, ..plan() }, Preset::Paper.settings());
    let mut training = Training::new(plan.clone(), settings.clone()).unwrap();
    let started = training.progress.next_episode;
    for episode in 0..2500 {
        training.progress.records.push(EpisodeRecord {
            episode,
            steps: episode + 1,
            episode_return: -0.1 * episode as f32,
            epsilon: 1.0 / f64::from(episode + 1),
            loss: (episode > 100).then(|| f64::from(episode).sqrt()),
            blocked: episode / 3,
            terminated: episode % 2 == 0,
        });
    }
    training.progress.next_episode = started + 2500;
    let bytes = bytes_of(&training);
    let loaded = load(&bytes, plan.clone(), settings.clone()).unwrap();
    assert_eq!(loaded.progress, training.progress);
    // A missing record is rejected.
    training.progress.next_episode += 1;
    let message = load(&bytes_of(&training), plan, settings).unwrap_err();
    assert!(message.contains("the number of started episodes is inconsistent"), "{message}");
}
