//! Images as a stock ROS 2 tool receives them: by CycloneDDS, an independent implementation.

use evac_tests::{Nodes, PATIENCE, repository};

const FRAMES: u64 = 50;

fn read_images(nodes: &Nodes, options: &[&str]) -> serde_json::Value {
    let python = std::env::var("EVAC_PYTHON")
        .expect("EVAC_PYTHON names a python with the peers: run launch_scripts/test.sh");
    let mut reader = nodes.command(python);
    reader
        .arg(repository().join("tests/peers/image_reader.py"))
        .args(["--frames", &FRAMES.to_string(), "--timeout", &PATIENCE.as_secs().to_string()])
        .args(options);
    let (status, text, error) = nodes.run(&mut reader);
    assert!(status.success(), "{options:?}: {error}");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn cyclone_dds_reads_the_images_of_a_training() {
    let mut nodes = Nodes::new();
    let out = format!("out:='{}'", nodes.path("run").display());
    nodes.start_simulator(&[]);
    nodes.start_agent("train", &["episodes:=100000", &out]);
    for options in [&[][..], &["--best-effort"]] {
        let images = read_images(&nodes, options);
        let expected = serde_json::json!({
            "frames": FRAMES, "width": 20, "height": 7, "encoding": "rgb8", "step": 60,
            "bytes": 420, "frame_id": "camera_optical_frame", "stamps_increase": true,
        });
        assert_eq!(images, expected, "{options:?}");
    }
}
