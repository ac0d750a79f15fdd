//! Writes a valid seed input for each target to `corpus/TARGET`.

use std::{collections::BTreeMap, fs, path::Path};

use evac_fuzz::{Files, Room, NullListener, plan, settings};
use evac_msgs::{ActionCommand, reset, step};
use ros_interfaces::{sensor_msgs::Image};
use learning::{checkpoint::model_bytes, run::RunDirectory, training::Training};
use ros_runtime::parameters::ParameterValue;
use ros_interfaces::rcl_interfaces::{Parameter, ParameterValue as Message, set_parameters};
use rustdds::{RepresentationIdentifier, serialization::to_writer_with_rep_id};
use serde::Serialize;

fn write(target: &str, name: &str, bytes: &[u8]) {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target);
    fs::create_dir_all(&directory).expect("a directory");
    fs::write(directory.join(name), bytes).expect("a file");
}

fn encoded(message: &impl Serialize) -> Vec<u8> {
    let mut bytes = Vec::new();
    to_writer_with_rep_id(&mut bytes, message, RepresentationIdentifier::CDR_LE)
        .expect("the message can be encoded");
    bytes
}

fn main() {
    let request = |kind: u8, message: Vec<u8>| [&[kind, 0], &message[..]].concat();
    let reset = reset::Request { request: 1, seed: 7, scenario: "three_moving".to_owned() };
    write("service_requests", "reset", &request(0, encoded(&reset)));
    let step = step::Request { episode: 0, step: 0, action: 3 };
    write("service_requests", "step", &request(1, encoded(&step)));
    let command = ActionCommand { action: 3, ..Default::default() };
    write("service_requests", "command", &request(2, encoded(&command)));
    let image = Image {
        height: 7,
        width: 20,
        encoding: "rgb8".to_owned(),
        step: 60,
        data: vec![7; 420],
        ..Default::default()
    };
    write("service_requests", "image", &request(3, encoded(&image)));

    let line = "-p\nscenario:=concave\n-p\nfixed_exit:=[2.0, 0.5]\n-r\n__ns:=/robot1";
    let value = Message::from(ParameterValue::DoubleArray(vec![0.1, 0.2]));
    let changes = vec![Parameter { name: "fixed_cylinders".to_owned(), value }];
    let set = encoded(&set_parameters::Request { parameters: changes });
    write("parameters", "both", &[&[line.len() as u8], line.as_bytes(), &set].concat());

    let yaml = "/**:\n  ros__parameters: {seed: 3}\nrobot1:\n  one: {two: {sim_node: \
                {ros__parameters: {camera: {height: 0.09}, fixed_exit: [1, 0.5]}}}}\n";
    write("yaml", "nested", yaml.as_bytes());

    let mut training = Training::new(plan(), settings()).expect("a network");
    // Stops in the second episode, when the environment fails. The replay memory is full by then.
    let _ = training.run(&mut [Room::new(18)], &mut NullListener);
    let files = Files::new(&[]);
    let path = files.path("checkpoint.safetensors");
    training.write_checkpoint(&path).expect("a checkpoint");
    write("checkpoint", "middle", &fs::read(path).expect("a readable checkpoint"));

    let config = BTreeMap::from([
        ("hidden_layers".to_owned(), ParameterValue::IntegerArray(vec![2])),
        ("observation_frames".to_owned(), ParameterValue::Integer(2)),
    ]);
    let directory = RunDirectory::open(Path::new(files.directory())).expect("a directory");
    directory.write_config(&BTreeMap::from([("agent_node".to_owned(), config)])).expect("a file");
    let config = fs::read(directory.file(RunDirectory::CONFIG)).expect("a readable file");
    let model = model_bytes(training.learner().network()).expect("weights");
    let length = (config.len() as u16).to_le_bytes();
    write("model", "small", &[&length[..], &config, &model].concat());
}
