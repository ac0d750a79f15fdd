use super::{reset_ledger::NUMBERINGS, *};
use crate::{camera::CameraSettings, world::WorldSettings};

const ALICE: ClientId = [1; 16];
const BOB: ClientId = [2; 16];

fn session() -> Session {
    let world = World::new(WorldSettings::default(), Scenario::Empty, 0).unwrap();
    let (session, first) =
        Session::new(world, Camera::new(CameraSettings::default()).unwrap(), 0.5);
    assert_eq!(first.header.stamp, messages::stamp(500_000_000), "the clock's first time");
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

/// The stamp of an image that is sent between steps.
fn frame_stamp(session: &mut Session) -> Time {
    session.pass_time();
    session.image().header.stamp
}

#[test]
fn episode_numbers_tell_simulator_and_episode() {
    let mut session = session();
    let first = session.episode_number();
    assert_eq!(first as u32, 1);
    let second = reset(&mut session, ALICE, 1).episode;
    assert_eq!(second, first + 1);
    assert_ne!(second >> 32, 0);
}

#[test]
fn a_repeated_reset_is_answered_as_before_and_resets_nothing() {
    let mut session = session();
    let answer = reset(&mut session, ALICE, 5);
    step(&mut session, answer.episode, 1, 3);
    let (again, executed) = session.reset(ALICE, &request(5, 7), Scenario::Empty);
    assert_eq!((again, executed), (answer.clone(), None));
    // Another client that counts alike is another client once the robot has moved,
    let other = reset(&mut session, BOB, 5);
    assert_eq!(other.episode, answer.episode + 1);
    // but by hand each call has a client of its own.
    assert_eq!(reset(&mut session, [3; 16], 5), other);
    step(&mut session, other.episode, 1, 3);
    // An older one, and one that another client's reset has replaced.
    assert_eq!(reset(&mut session, ALICE, 4).status, status::SUPERSEDED);
    assert_eq!(reset(&mut session, ALICE, 5).status, status::SUPERSEDED);
    assert_eq!(reset(&mut session, ALICE, 6).status, status::OK);
}

/// A client that cannot send is replaced by another one, and what it had sent may come afterwards.
#[test]
fn a_program_is_known_by_its_numbers_whichever_client_it_asks_by() {
    let mut session = session();
    let drawn = 7 << 32;
    let first = reset(&mut session, BOB, drawn + 1);
    step(&mut session, first.episode, 1, 3);
    assert_eq!(reset(&mut session, ALICE, drawn + 1), first);
    let second = reset(&mut session, BOB, drawn + 2);
    assert_eq!(second.episode, first.episode + 1);
    assert_eq!(reset(&mut session, ALICE, drawn + 1).status, status::SUPERSEDED);
    // Another program's numbers may well be smaller.
    assert_eq!(reset(&mut session, ALICE, 6 << 32).episode, second.episode + 1);
}

#[test]
fn resets_without_a_number_are_all_new() {
    let mut session = session();
    let first = reset(&mut session, ALICE, 0).episode;
    assert_eq!(reset(&mut session, ALICE, 0).episode, first + 1);
}

#[test]
fn a_scenario_that_does_not_exist_changes_nothing() {
    let mut session = session();
    let before = session.episode_number();
    let wrong = reset::Request { scenario: "desert".into(), ..request(1, 7) };
    let (answer, executed) = session.reset(ALICE, &wrong, Scenario::Empty);
    assert_eq!((answer.status, answer.success), (status::INVALID_SCENARIO, false));
    assert!(answer.message.contains("desert") && answer.message.contains("three_moving"));
    assert_eq!((session.episode_number(), executed), (before, None));
    // The number is not used up.
    assert_eq!(reset(&mut session, ALICE, 1).status, status::OK);
}

#[test]
fn a_repeated_step_is_answered_as_before_and_moves_nothing() {
    let mut session = session();
    let episode = reset(&mut session, ALICE, 1).episode;
    let first = step(&mut session, episode, 1, 3);
    assert_eq!((first.status, first.step, first.episode), (status::OK, 1, episode));
    let (again, executed) = session.step(&step::Request { episode, step: 1, action: 3 });
    assert_eq!((again, executed), (first, None));
    assert_eq!(step(&mut session, episode, 1, 4).status, status::ACTION_DIFFERS);
    assert_eq!(session.world.steps(), 1);
}

#[test]
fn steps_come_in_their_order() {
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
fn zeros_are_for_hands() {
    let mut session = session();
    for number in 1..=3 {
        assert_eq!(step(&mut session, 0, 0, 3).step, number);
    }
}

#[test]
fn every_wrong_episode_is_told_apart() {
    let mut session = session();
    let old = reset(&mut session, ALICE, 1).episode;
    let current = reset(&mut session, BOB, 2).episode;
    let status_of = |session: &mut Session, episode| step(session, episode, 1, 3).status;
    assert_eq!(status_of(&mut session, old), status::SUPERSEDED);
    assert_eq!(status_of(&mut session, current + 1), status::UNKNOWN_EPISODE);
    assert_eq!(status_of(&mut session, 12_345), status::UNKNOWN_EPISODE);
    assert_eq!(status_of(&mut session, current ^ (1 << 40)), status::SIMULATOR_RESTARTED);
    assert_eq!(session.world.steps(), 0);
}

#[test]
fn actions_over_six_are_refused() {
    let mut session = session();
    let answer = step(&mut session, 0, 0, 9);
    assert_eq!(answer.status, status::INVALID_ACTION);
    assert!(answer.message.contains('9'), "{}", answer.message);
    assert_eq!(session.world.steps(), 0);
}

#[test]
fn after_the_end_there_is_the_last_answer_and_nothing_else() {
    let world =
        World::new(WorldSettings { max_steps: 2, ..Default::default() }, Scenario::Empty, 3);
    let camera = Camera::new(CameraSettings::default()).unwrap();
    let (mut session, _) = Session::new(world.unwrap(), camera, 0.5);
    let episode = session.episode_number();
    step(&mut session, episode, 1, 0);
    let last = step(&mut session, episode, 2, 0);
    assert!(last.truncated || last.terminated);
    assert_eq!(step(&mut session, episode, 3, 0).status, status::EPISODE_OVER);
    assert_eq!(step(&mut session, 0, 0, 0).status, status::EPISODE_OVER);
    assert_eq!(step(&mut session, episode, 2, 0), last);
}

#[test]
fn the_first_move_binds_an_episode_to_its_way() {
    let mut session = session();
    let command = ActionCommand { action: 3, ..ActionCommand::default() };
    assert!(session.command(&command).unwrap().is_some());
    assert_eq!(step(&mut session, 0, 0, 3).status, status::SUPERSEDED);
    let episode = reset(&mut session, ALICE, 1).episode;
    assert_eq!(step(&mut session, episode, 1, 3).status, status::OK);
    assert!(session.command(&command).unwrap_err().contains("service"));
    let for_watchers = ActionCommand { sent_by_service: true, ..command };
    assert_eq!(session.command(&for_watchers), Ok(None));
    assert_eq!(session.world.steps(), 1);
}

#[test]
fn time_passes_with_what_is_executed_only() {
    let mut session = session();
    let episode = reset(&mut session, ALICE, 1).episode;
    reset(&mut session, ALICE, 1);
    let answer = step(&mut session, episode, 1, 3);
    step(&mut session, episode, 1, 3);
    step(&mut session, episode, 7, 3);
    assert_eq!(answer.image.header.stamp, messages::stamp(1_500_000_000));
    assert_eq!(session.time.now(), 1_500_000_000);
}

#[test]
fn the_memory_of_clients_is_bounded() {
    let mut session = session();
    for client in 0..1000u64 {
        let mut id = [0; 16];
        id[..8].copy_from_slice(&client.to_le_bytes());
        session.reset(id, &request(1, client), Scenario::Empty);
    }
    assert_eq!(session.resets.len(), NUMBERINGS);
}

#[test]
fn the_path_begins_anew_with_each_episode_and_has_every_step() {
    let mut session = session();
    let episode = reset(&mut session, ALICE, 1).episode;
    assert_eq!(session.path().len(), 1);
    let (start, _) = (session.path()[0], step(&mut session, episode, 1, 3));
    step(&mut session, episode, 1, 3);
    step(&mut session, episode, 2, 3);
    assert_eq!(session.path().len(), 3);
    assert_eq!(session.path()[0], start);
    let times: Vec<u64> = session.path().iter().map(|visit| visit.time).collect();
    assert_eq!(times, [1_000_000_000, 1_500_000_000, 2_000_000_000]);
    assert_eq!(session.path()[2].pose, *session.world().robot());
    assert_eq!(session.now(), messages::stamp(2_000_000_000));
    reset(&mut session, ALICE, 2);
    assert_eq!(session.path().len(), 1);
}

#[test]
fn what_is_fixed_counts_from_the_next_reset_on() {
    let mut session = session();
    let robot = |numbers| Layout::from_lists(&[], &[], numbers).unwrap();
    let before = *session.world().robot();
    session.set_layout(robot(&[0.5, -0.5, 0.0]));
    assert_eq!(*session.world().robot(), before);
    let placed = reset(&mut session, ALICE, 1);
    assert_eq!(*session.world().robot(), Isometry2::translation(0.5, -0.5));

    // In the wall: refused as long as it is so.
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

/// A robot takes its time: what is said meanwhile, or in answer to an older image, is refused.
#[test]
fn a_moving_robot_is_not_commanded_and_an_old_image_not_answered() {
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
    // While it moves, nothing counts.
    session.set_wall_time(1_000_000_300);
    let meanwhile = frame_stamp(&mut session);
    let refused = session.command(&command(meanwhile)).unwrap_err();
    assert!(refused.starts_with("the robot is moving"), "{refused}");
    assert_eq!((session.finish_motion(), steps(&session)), (None, 0));
    session.set_wall_time(1_000_000_450);
    let executed = session.finish_motion().unwrap();
    assert_eq!((executed.step, steps(&session)), (1, 1));
    // An image of before the end is an old one, even if it comes after it.
    let refused = session.command(&command(meanwhile)).unwrap_err();
    assert!(refused.contains("the robot is elsewhere"), "{refused}");
    assert_eq!(session.command(&command(executed.header.stamp)), Ok(None));
    // By hand, without a stamp, the image is whatever there is.
    session.set_wall_time(1_000_001_000);
    session.finish_motion().unwrap();
    assert_eq!(session.command(&command(Time::default())), Ok(None));
}

#[test]
fn the_next_episode_is_anybodys_again() {
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
