//! Checks the services, topics and parameters of `sim_node` with a client over DDS, including every
//! status of `/reset` and `/step`.

use std::time::Duration;

use evac_msgs::{ActionCommand, EpisodeStatus, Reset, Step, reset, status, step};
use evac_tests::{Nodes, TIMEOUT};
use ros_interfaces::sensor_msgs::Image;
use ros_runtime::{
    Node, Publisher,
    node::reliable,
    parameters::{ParameterClient, ParameterValue},
    service::ServiceClient,
};

/// A client of the simulator.
struct Client {
    node: Node,
    reset: ServiceClient<Reset>,
    step: ServiceClient<Step>,
}

impl Client {
    fn new(nodes: &Nodes) -> Client {
        let mut node = nodes.client();
        let reset = node.create_client("reset").expect("a client");
        let step = node.create_client("step").expect("a client");
        Client { node, reset, step }
    }

    fn reset(&self, request: u64, seed: u64, scenario: &str) -> reset::Response {
        let request = reset::Request { request, seed, scenario: scenario.to_owned() };
        self.node.block_on(self.reset.call(request, Some(TIMEOUT))).expect("a response")
    }

    fn step(&self, episode: u64, step: u32, action: u8) -> step::Response {
        let request = step::Request { episode, step, action };
        self.node.block_on(self.step.call(request, Some(TIMEOUT))).expect("a response")
    }
}

fn assert_is_camera_image(image: &Image) {
    assert_eq!((image.width, image.height, image.step), (20, 7, 60));
    assert_eq!((image.encoding.as_str(), image.data.len()), ("rgb8", 420));
    assert_eq!(image.header.frame_id, "camera_optical_frame");
}

#[track_caller]
fn assert_refused(response: &step::Response, expected: u8, message: &str) {
    let found = (status::name(response.status), response.success);
    assert_eq!(found, (status::name(expected), false), "{}", response.message);
    assert!(response.message.contains(message), "{}", response.message);
    assert_eq!(response.image, Image::default(), "a refusal carries an empty image");
}

#[test]
fn reset_and_step_return_every_status() {
    let mut nodes = Nodes::new();
    nodes.start_simulator(&["max_steps:=3"]);
    let (alice, bob) = (Client::new(&nodes), Client::new(&nodes));

    let first = alice.reset(1, 7, "");
    assert_eq!((first.success, first.status), (true, status::OK), "{}", first.message);
    assert_is_camera_image(&first.image);
    let step = alice.step(first.episode, 1, 3);
    assert_eq!((step.status, step.step, step.episode), (status::OK, 1, first.episode));
    assert_is_camera_image(&step.image);

    // A repeated step returns the stored response; with a different action, it is refused.
    assert_eq!(alice.step(first.episode, 1, 3), step);
    assert_refused(
        &alice.step(first.episode, 1, 4),
        status::ACTION_DIFFERS,
        "with action 3, not 4",
    );
    // An invalid action, a step out of order, an unknown episode, and one from before a restart.
    assert_refused(&alice.step(first.episode, 2, 9), status::INVALID_ACTION, "9");
    assert_refused(&alice.step(first.episode, 3, 3), status::OUT_OF_ORDER, "the next step is 2");
    assert_refused(&alice.step(first.episode + 1, 2, 3), status::UNKNOWN_EPISODE, "never");
    let elsewhere = first.episode ^ (1 << 35);
    assert_refused(&alice.step(elsewhere, 2, 3), status::SIMULATOR_RESTARTED, "restarted");

    // A repeated reset and one with an unknown scenario leave the episode unchanged.
    assert_eq!(alice.reset(1, 7, ""), first);
    let unknown = alice.reset(2, 7, "desert");
    assert_eq!((unknown.status, unknown.success), (status::INVALID_SCENARIO, false));
    assert!(unknown.message.contains("desert"), "{}", unknown.message);
    assert_eq!(alice.step(first.episode, 2, 3).status, status::OK);

    // A second client replaces the episode.
    let second = bob.reset(20, 8, "three_moving");
    assert_eq!(second.episode, first.episode + 1);
    assert_refused(&alice.step(first.episode, 3, 3), status::SUPERSEDED, "replaced");
    assert_eq!(alice.reset(1, 7, "").status, status::SUPERSEDED);
    assert_eq!(bob.reset(19, 8, "").status, status::SUPERSEDED);

    // Steps after the end of the episode.
    let mut last = second.episode;
    for number in 1..=3 {
        let response = bob.step(second.episode, number, 0);
        assert_eq!(response.status, status::OK);
        last = response.episode;
        if response.terminated || response.truncated {
            let after = bob.step(second.episode, number + 1, 0);
            assert_refused(&after, status::EPISODE_OVER, "reset");
        }
    }
    assert_eq!(last, second.episode);
    assert_refused(&bob.step(0, 0, 0), status::EPISODE_OVER, "reset");
}

#[test]
fn a_seed_determines_the_episode_in_any_simulator() {
    let mut nodes = Nodes::new();
    nodes.start_simulator(&[]);
    let client = Client::new(&nodes);
    let episode = |request| {
        let start = client.reset(request, 42, "three_moving");
        let mut images = vec![start.image.data];
        for number in 1..=20 {
            let response = client.step(start.episode, number, (number % 7) as u8);
            images.push(response.image.data);
            if response.terminated {
                break;
            }
        }
        images
    };
    let first = episode(1);
    nodes.kill("sim_node");
    nodes.start_simulator(&["seed:=5"]);
    assert_eq!(episode(2), first);
}

#[test]
fn an_action_moves_the_robot_and_publishes_a_status() {
    let mut nodes = Nodes::new();
    nodes.start_simulator(&[]);
    let mut client = Client::new(&nodes);
    let actions: Publisher<ActionCommand> =
        client.node.create_publisher("action", reliable(1)).expect("a publisher");
    let statuses = client
        .node
        .create_subscription::<EpisodeStatus>("episode", reliable(10))
        .expect("a subscription");
    let start = client.reset(1, 7, "empty");
    // Commands and statuses may be lost until discovery is complete.
    let status = client.node.block_on(async {
        for _ in 0..100 {
            actions.publish_with(|| ActionCommand { action: 3, ..Default::default() });
            let next =
                tokio::time::timeout(Duration::from_millis(200), statuses.async_take()).await;
            if let Ok(Ok((status, _))) = next
                && status.step > 0
            {
                return status;
            }
        }
        panic!("no action was executed");
    });
    assert_eq!((status.episode, status.action), (start.episode, 3));
    assert_eq!((status.scenario.as_str(), status.seed), ("empty", 7));
    // After the first move, only the topic controls the episode.
    let refused = client.step(start.episode, status.step + 1, 3);
    assert_refused(&refused, status::SUPERSEDED, "the /action topic controls the robot");
}

#[test]
fn parameter_services_return_values_and_refuse_invalid_ones() {
    let mut nodes = Nodes::new();
    nodes.start_simulator(&["scenario:=concave", "fixed_exit:=[2, 0.5]"]);
    let mut node = nodes.client();
    let parameters = ParameterClient::new(&mut node, "sim_node").expect("a client");
    let values = node.block_on(parameters.values(TIMEOUT)).expect("a response");
    assert_eq!(values["scenario"], ParameterValue::String("concave".into()));
    assert_eq!(values["fixed_exit"], ParameterValue::DoubleArray(vec![2.0, 0.5]));
    assert_eq!(values["camera.height"], ParameterValue::Double(0.09));
    let set = |name: &str, value| node.block_on(parameters.set(name, value, TIMEOUT));
    assert_eq!(set("scenario", ParameterValue::String("empty".into())), Ok(Ok(())));
    let desert = set("scenario", ParameterValue::String("desert".into()));
    assert!(desert.expect("a response").unwrap_err().contains("expected one of empty"));
    let seed = set("seed", ParameterValue::Integer(3));
    assert!(seed.expect("a response").unwrap_err().contains("read-only"));
}

/// DDS keeps the reader of a killed client for about 50 s, and up to 8,192 responses for it, after
/// which the server's send window is full.
#[test]
fn a_killed_client_does_not_block_the_server() {
    const STEPS: u32 = 10_000;
    let mut nodes = Nodes::new();
    nodes.start_simulator(&["max_steps:=1000000"]);
    let out = format!("out:='{}'", nodes.path("run").display());
    nodes.start_agent("train", &[&out, "preset:=paper", "episodes:=100000"]);
    nodes.wait_for_steps(20);
    nodes.kill("agent_node");
    let client = Client::new(&nodes);
    let mut episode = client.reset(1, 1, "");
    let (mut resets, mut step) = (1, 0);
    for _ in 0..STEPS {
        step += 1;
        let response = client.step(episode.episode, step, (step % 7) as u8);
        assert_eq!(response.status, status::OK, "{}", response.message);
        if response.terminated {
            resets += 1;
            episode = client.reset(resets, resets, "");
            step = 0;
        }
    }
    let log = nodes.log("sim_node");
    assert!(log.contains("recreating the server"), "the window was never full:\n{log}");
}
