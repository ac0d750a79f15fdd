//! Loads a trained model and its configuration, as `evaluate` and `drive` do. If it loads, its
//! policy must be able to decide.

#![no_main]

use agent_node::ros::TrainedModel;
use learning::run::RunDirectory;
use libfuzzer_sys::fuzz_target;
use ros_runtime::{Arguments, names::Naming, parameters::Parameters};
use task::Image;

fuzz_target!(|data: &[u8]| {
    let [low, high, data @ ..] = data else {
        return;
    };
    let length = usize::from(u16::from_le_bytes([*low, *high]));
    let (config, model) = data.split_at(data.len().min(length));
    let files =
        evac_fuzz::Files::new(&[(RunDirectory::CONFIG, config), (RunDirectory::MODEL, model)]);
    let line = ["agent_node", "--ros-args", "-p", &format!("model:='{}'", files.directory())];
    let arguments = Arguments::parse(line.map(str::to_owned)).expect("a command line");
    let naming = Naming::new("agent_node", &[]).expect("a name");
    let parameters = Parameters::new(&naming, &arguments).expect("no files");
    if let Ok(model) = TrainedModel::declare(&parameters)
        && let Ok(mut policy) = model.policy()
    {
        let image = Image::try_from([0; Image::BYTES].as_slice()).expect("an image");
        policy.begin(image.clone());
        let decision = policy.decide();
        policy.observe(decision.action, image);
        policy.decide();
    }
});
