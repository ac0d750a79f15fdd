//! Parses a node's command line and a `set_parameters` request, and applies both.

#![no_main]

use libfuzzer_sys::fuzz_target;
use ros_interfaces::rcl_interfaces::set_parameters;
use ros_runtime::{
    Arguments,
    names::Naming,
    parameters::{Descriptor, ParameterValue, Parameters},
};
use rustdds::{RepresentationIdentifier, serialization::deserialize_from_cdr_with_rep_id};

fuzz_target!(|data: &[u8]| {
    let [length, data @ ..] = data else {
        return;
    };
    let (line, request) = data.split_at(data.len().min(usize::from(*length)));
    let line = String::from_utf8_lossy(line);
    // One argument per line. Parameter files are excluded: they have their own target.
    let items = line.lines().filter(|item| !item.contains("--params-file"));
    let items = ["sim_node", "--ros-args"].into_iter().chain(items).map(str::to_owned);
    let Ok(arguments) = Arguments::parse(items) else {
        return;
    };
    let Ok(naming) = Naming::new("sim_node", &arguments.remaps) else {
        return;
    };
    let _ = naming.resolve("~/set_parameters");
    let Ok(parameters) = Parameters::new(&naming, &arguments) else {
        return;
    };
    let _ = sim_node::ros::declare_room(&parameters);
    let _ = parameters.declare("anything", vec![String::new()], Descriptor::dynamic(""));
    let _ = parameters.reject_undeclared();
    let request = deserialize_from_cdr_with_rep_id::<set_parameters::Request>(
        request,
        RepresentationIdentifier::CDR_LE,
    );
    if let Ok((request, _)) = request {
        for change in request.parameters {
            if let Some(value) = ParameterValue::from_message(&change.value) {
                if let Err(error) = parameters.set(&change.name, value) {
                    assert!(!error.to_string().is_empty());
                }
            }
        }
    }
    let _ = parameters.values();
});
