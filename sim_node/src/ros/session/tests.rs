//! Tests of the protocol.

use nalgebra::Isometry2;

use super::{reset_ledger::MAX_SENDERS, *};
use crate::{
    camera::{Camera, CameraSettings},
    world::WorldSettings,
};

const ALICE: ClientId = [1; 16];
const BOB: ClientId = [2; 16];

fn simulation(world: World) -> Simulation {
    Simulation::new(world, Camera::new(CameraSettings::default()).unwrap())
}

fn session() -> Session {
    let world = World::new(WorldSettings::default(), Scenario::Empty, 0).unwrap();
    let (session, first) = Session::new(simulation(world), 0.5);
    assert_eq!(first.header.stamp, messages::stamp(500_000_000), "the first stamp");
    session
}

fn request(request: u64, seed: u64) -> reset::Request {
    reset::Request { request, seed, scenario: String::new() }
}

fn reset(session: &mut Session, client: ClientId, number: u64) -> reset::Response {
    session.reset(client, &request(number, 7), Scenario::Empty).0
}

fn step(session: &mut Session, episode: u64, number: u32, action: u8) -> step::Response {
    session.step(&step::Request { episode, step: number, action }).0
}

/// Renders an image between steps. Returns its stamp.
fn frame_stamp(session: &mut Session) -> Time {
    session.take_image();
    session.image().header.stamp
}

#[test]
fn an_episode_number_identifies_the_run_and_the_episode() {
    let mut session = session();
    let first = session.episode_number();
    assert_eq!(first as u32, 1);
    let second = reset(&mut session, ALICE, 1).episode;
    assert_eq!(second, first + 1);
    assert_ne!(second >> 32, 0);
}

#[test]
fn a_retried_reset_returns_the_stored_response_and_resets_nothing() {
    let mut session = session();
    let response = reset(&mut session, ALICE, 5);
    step(&mut session, response.episode, 1, 3);
    let (retried, executed) = session.reset(ALICE, &request(5, 7), Scenario::Empty);
    assert_eq!((retried, executed), (response.clone(), None));
    // After a step, the same number from another client is a new request.
    let other = reset(&mut session, BOB, 5);
    assert_eq!(other.episode, response.episode + 1);
    // Without a step it is a retry, because command-line tools create a client for each call.
    assert_eq!(reset(&mut session, [3; 16], 5), other);
    step(&mut session, other.episode, 1, 3);
    // The first is out of order, the second was superseded by another client, the third is new.
    assert_eq!(reset(&mut session, ALICE, 4).status, status::SUPERSEDED);
    assert_eq!(reset(&mut session, ALICE, 5).status, status::SUPERSEDED);
    assert_eq!(reset(&mut session, ALICE, 6).status, status::OK);
}

/// A program may replace its DDS client, and requests from the old client may still arrive.
#[test]
fn a_program_is_identified_by_its_request_numbers_from_any_client() {
    let mut session = session();
    let program = 7 << 32;
    let first = reset(&mut session, BOB, program + 1);
    step(&mut session, first.episode, 1, 3);
    assert_eq!(reset(&mut session, ALICE, program + 1), first);
    let second = reset(&mut session, BOB, program + 2);
    assert_eq!(second.episode, first.episode + 1);
    assert_eq!(reset(&mut session, ALICE, program + 1).status, status::SUPERSEDED);
    // The numbers of another program may be smaller.
    assert_eq!(reset(&mut session, ALICE, 6 << 32).episode, second.episode + 1);
}

#[test]
fn every_reset_with_request_number_0_is_new() {
    let mut session = session();
    let first = reset(&mut session, ALICE, 0).episode;
    assert_eq!(reset(&mut session, ALICE, 0).episode, first + 1);
}

#[test]
fn rejects_an_unknown_scenario_and_changes_nothing() {
    let mut session = session();
    let before = session.episode_number();
    let invalid = reset::Request { scenario: "desert".into(), ..request(1, 7) };
    let (response, executed) = session.reset(ALICE, &invalid, Scenario::Empty);
    assert_eq!((response.status, response.success), (status::INVALID_SCENARIO, false));
    assert!(response.message.contains("desert") && response.message.contains("three_moving"));
    assert_eq!((session.episode_number(), executed), (before, None));
    // The request number can be used again.
    assert_eq!(reset(&mut session, ALICE, 1).status, status::OK);
}

#[test]
fn a_retried_step_returns_the_stored_response_and_moves_nothing() {
    let mut session = session();
    let episode = reset(&mut session, ALICE, 1).episode;
    let first = step(&mut session, episode, 1, 3);
    assert_eq!((first.status, first.step, first.episode), (status::OK, 1, episode));
    let (retried, executed) = session.step(&step::Request { episode, step: 1, action: 3 });
    assert_eq!((retried, executed), (first, None));
    assert_eq!(step(&mut session, episode, 1, 4).status, status::ACTION_DIFFERS);
    assert_eq!(session.world().steps(), 1);
}

#[test]
fn rejects_steps_out_of_order() {
    let mut session = session();
    let episode = reset(&mut session, ALICE, 1).episode;
    assert_eq!(step(&mut session, episode, 2, 3).status, status::OUT_OF_ORDER);
    step(&mut session, episode, 1, 3);
    step(&mut session, episode, 2, 3);
    let late = step(&mut session, episode, 1, 3);
    assert_eq!((late.status, late.success), (status::OUT_OF_ORDER, false));
    assert_eq!(late.image, Image::default());
    assert_eq!(late.message, "step 1 is out of order: the next step is 3");
}

#[test]
fn episode_0_and_step_0_mean_the_current_episode_and_the_next_step() {
    let mut session = session();
    for number in 1..=3 {
        assert_eq!(step(&mut session, 0, 0, 3).step, number);
    }
}

#[test]
fn the_status_of_an_invalid_episode_states_the_reason() {
    let mut session = session();
    let old = reset(&mut session, ALICE, 1).episode;
    let current = reset(&mut session, BOB, 2).episode;
    let status_of = |session: &mut Session, episode| step(session, episode, 1, 3).status;
    assert_eq!(status_of(&mut session, old), status::SUPERSEDED);
    assert_eq!(status_of(&mut session, current + 1), status::UNKNOWN_EPISODE);
    assert_eq!(status_of(&mut session, 12_345), status::UNKNOWN_EPISODE);
    assert_eq!(status_of(&mut session, current ^ (1 << 40)), status::SIMULATOR_RESTARTED);
    assert_eq!(session.world().steps(), 0);
}

#[test]
fn rejects_an_action_above_6() {
    let mut session = session();
    let response = step(&mut session, 0, 0, 9);
    assert_eq!(response.status, status::INVALID_ACTION);
    assert!(response.message.contains('9'), "{}", response.message);
    assert_eq!(session.world().steps(), 0);
}

#[test]
fn after_the_end_of_the_episode_only_a_retry_of_the_last_step_succeeds() {
    let world =
        World::new(WorldSettings { max_steps: 2, ..Default::default() }, Scenario::Empty, 3);
    let (mut session, _) = Session::new(simulation(world.unwrap()), 0.5);
    let episode = session.episode_number();
    step(&mut session, episode, 1, 0);
    let last = step(&mut session, episode, 2, 0);
    assert!(last.truncated || last.terminated);
    assert_eq!(step(&mut session, episode, 3, 0).status, status::EPISODE_OVER);
    assert_eq!(step(&mut session, 0, 0, 0).status, status::EPISODE_OVER);
    assert_eq!(step(&mut session, episode, 2, 0), last);
}

#[test]
fn the_first_interface_used_controls_the_episode() {
    let mut session = session();
    let command = ActionCommand { action: 3, ..ActionCommand::default() };
    assert!(session.command(&command).unwrap().is_some());
    assert_eq!(step(&mut session, 0, 0, 3).status, status::SUPERSEDED);
    let episode = reset(&mut session, ALICE, 1).episode;
    assert_eq!(step(&mut session, episode, 1, 3).status, status::OK);
    assert!(session.command(&command).unwrap_err().contains("service"));
    let informational = ActionCommand { sent_by_service: true, ..command };
    assert_eq!(session.command(&informational), Ok(None));
    assert_eq!(session.world().steps(), 1);
}

#[test]
fn only_executed_requests_advance_the_time() {
    let mut session = session();
    let episode = reset(&mut session, ALICE, 1).episode;
    reset(&mut session, ALICE, 1);
    let response = step(&mut session, episode, 1, 3);
    step(&mut session, episode, 1, 3);
    step(&mut session, episode, 7, 3);
    assert_eq!(response.image.header.stamp, messages::stamp(1_500_000_000));
    assert_eq!(session.time.now(), 1_500_000_000);
}

#[test]
fn the_number_of_stored_clients_is_bounded() {
    let mut session = session();
    for client in 0..1000u64 {
        let mut id = [0; 16];
        id[..8].copy_from_slice(&client.to_le_bytes());
        session.reset(id, &request(1, client), Scenario::Empty);
    }
    assert_eq!(session.resets.len(), MAX_SENDERS);
}

#[test]
fn the_path_has_the_start_and_every_step_of_the_current_episode() {
    let mut session = session();
    let episode = reset(&mut session, ALICE, 1).episode;
    assert_eq!(session.path().len(), 1);
    let (start, _) = (session.path()[0], step(&mut session, episode, 1, 3));
    step(&mut session, episode, 1, 3);
    step(&mut session, episode, 2, 3);
    assert_eq!(session.path().len(), 3);
    assert_eq!(session.path()[0], start);
    let times: Vec<u64> = session.path().iter().map(|stamped| stamped.time).collect();
    assert_eq!(times, [1_000_000_000, 1_500_000_000, 2_000_000_000]);
    assert_eq!(session.path()[2].pose, *session.world().robot());
    assert_eq!(session.now(), messages::stamp(2_000_000_000));
    reset(&mut session, ALICE, 2);
    assert_eq!(session.path().len(), 1);
}

#[test]
fn a_fixed_layout_takes_effect_at_the_next_reset() {
    let mut session = session();
    let robot = |numbers| Layout::from_lists(&[], &[], numbers).unwrap();
    let before = *session.world().robot();
    session.set_layout(robot(&[0.5, -0.5, 0.0]));
    assert_eq!(*session.world().robot(), before);
    let placed = reset(&mut session, ALICE, 1);
    assert_eq!(*session.world().robot(), Isometry2::translation(0.5, -0.5));

    // Resets are refused while the fixed robot is inside a wall.
    session.set_layout(robot(&[1.25, 0.0, 0.0]));
    let refused = reset(&mut session, ALICE, 2);
    assert_eq!((refused.status, refused.success), (status::INVALID_SCENARIO, false));
    assert!(refused.message.contains("touches a wall"), "{}", refused.message);
    assert_eq!(refused.episode, placed.episode);
    assert_eq!(*session.world().robot(), Isometry2::translation(0.5, -0.5));
    assert_eq!(step(&mut session, placed.episode, 1, 3).status, status::OK);

    session.set_layout(Layout::default());
    assert_eq!(reset(&mut session, ALICE, 2).status, status::OK);
}

/// With a nonzero motion time, commands during a move and commands for an outdated image are
/// refused.
#[test]
fn rejects_commands_during_a_move_and_for_an_outdated_image() {
    let mut session = session();
    session.set_motion_time(400);
    session.set_wall_time(1_000_000_000);
    let first = frame_stamp(&mut session);
    assert_eq!(first, messages::stamp(1_000_000_000));
    let command = |stamp: Time| ActionCommand {
        header: Header { stamp, frame_id: String::new() },
        action: 3,
        sent_by_service: false,
    };
    let steps = |session: &Session| session.world().steps();
    assert_eq!(session.command(&command(first)), Ok(None));
    // The command arrives during the move.
    session.set_wall_time(1_000_000_300);
    let during_move = frame_stamp(&mut session);
    let refused = session.command(&command(during_move)).unwrap_err();
    assert!(refused.starts_with("the robot is moving"), "{refused}");
    assert_eq!((session.finish_motion(), steps(&session)), (None, 0));
    session.set_wall_time(1_000_000_450);
    let executed = session.finish_motion().unwrap();
    assert_eq!((executed.step, steps(&session)), (1, 1));
    // The command arrives after the move, but for an image taken during the move.
    let refused = session.command(&command(during_move)).unwrap_err();
    assert!(refused.starts_with("outdated image"), "{refused}");
    assert_eq!(session.command(&command(executed.header.stamp)), Ok(None));
    // A manual command has no stamp.
    session.set_wall_time(1_000_001_000);
    session.finish_motion().unwrap();
    assert_eq!(session.command(&command(Time::default())), Ok(None));
}

#[test]
fn both_interfaces_can_control_the_next_episode() {
    let mut session = session();
    let number = session.episode_number();
    let command = |action| ActionCommand { action, ..ActionCommand::default() };
    for action in (0..7).cycle() {
        let Ok(Some(executed)) = session.command(&command(action)) else { panic!("refused") };
        if executed.terminated || executed.truncated {
            break;
        }
    }
    assert_ne!(step(&mut session, 0, 0, 3).status, status::OK);
    let next = session.next_episode(Scenario::Concave).unwrap();
    assert_eq!((next.episode, next.step), (number + 1, 0));
    assert_eq!(session.scenario(), Scenario::Concave);
    assert_eq!(step(&mut session, 0, 0, 3).status, status::OK);
}
