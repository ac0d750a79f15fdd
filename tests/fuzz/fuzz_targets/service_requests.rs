//! Decodes requests, commands and images as the nodes do, and executes them.

#![no_main]

use std::cell::RefCell;

use agent_node::ros::image;
use evac_msgs::{ActionCommand, reset, step};
use ros_interfaces::sensor_msgs::Image;
use libfuzzer_sys::fuzz_target;
use rustdds::{RepresentationIdentifier, serialization::deserialize_from_cdr_with_rep_id};
use serde::de::DeserializeOwned;
use sim_node::{
    Simulation,
    camera::{Camera, CameraSettings},
    ros::Session,
    world::{World, WorldSettings},
};
use task::Scenario;

fn session() -> Session {
    let world = World::new(WorldSettings::default(), Scenario::Empty, 0).expect("a room");
    let camera = Camera::new(CameraSettings::default()).expect("a camera");
    Session::new(Simulation::new(world, camera), 0.5).0
}

fn decoded<T: DeserializeOwned>(encoding: u8, bytes: &[u8]) -> Option<T> {
    let encoding = match encoding & 1 {
        0 => RepresentationIdentifier::CDR_LE,
        _ => RepresentationIdentifier::CDR_BE,
    };
    deserialize_from_cdr_with_rep_id(bytes, encoding).ok().map(|(message, _)| message)
}

thread_local! {
    static SESSION: RefCell<Session> = RefCell::new(session());
}

fuzz_target!(|data: &[u8]| {
    let [kind, encoding, bytes @ ..] = data else {
        return;
    };
    SESSION.with_borrow_mut(|session| match kind % 4 {
        0 => {
            if let Some(request) = decoded::<reset::Request>(*encoding, bytes) {
                let client = [*encoding; 16];
                let (response, executed) = session.reset(client, &request, Scenario::Concave);
                assert_eq!(response.success, response.message.is_empty());
                assert!(executed.is_none() || response.success);
            }
        }
        1 => {
            if let Some(request) = decoded::<step::Request>(*encoding, bytes) {
                let (response, executed) = session.step(&request);
                assert_eq!(response.success, response.message.is_empty());
                assert!(executed.is_none() || response.success);
            }
        }
        2 => {
            if let Some(command) = decoded::<ActionCommand>(*encoding, bytes) {
                let _ = session.command(&command);
                session.set_wall_time(u64::from(*encoding) << 32);
                let _ = session.finish_motion();
            }
        }
        _ => {
            if let Some(message) = decoded::<Image>(*encoding, bytes) {
                let data = message.data.clone();
                if let Ok((image, _)) = image(message) {
                    assert_eq!(image.bytes()[..], data);
                }
            }
        }
    });
});
