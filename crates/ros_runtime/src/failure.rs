//! What becomes of a node when something within it fails: it ends with an error, so that whoever
//! started it can start it again.
//!
//! A program goes on when one of its threads panics. A node whose DDS has ended in that way would
//! hear nobody, be heard by nobody, and look alive. And RustDDS 0.15 as it is believes what a packet says
//! of its size: it takes gigabytes for some that are 60 bytes long. docs/reliability.md lists them.

use std::{fs, io, panic, process};

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// The exit status of a node that panicked, which is Rust's own.
const PANICKED: i32 = 101;

/// From now on a panic in any thread ends the process, once it was told of.
pub fn end_on_panic() {
    let tell = panic::take_hook();
    panic::set_hook(Box::new(move |panic| {
        tell(panic);
        // Not by the logger, which speaks over DDS, too.
        eprintln!(
            "a part of this node has failed, as said above, so all of it ends: start it again"
        );
        process::exit(PANICKED);
    }));
}

/// From now on the process ends when it asks for more memory than so many bytes (`SIGABRT`).
pub fn limit_memory(bytes: u64) -> io::Result<()> {
    let Rlimit { current, maximum } = getrlimit(Resource::Data);
    // A stricter limit is somebody's who knows the machine.
    let bytes = [Some(bytes), current, maximum].into_iter().flatten().min();
    Ok(setrlimit(Resource::Data, Rlimit { current: bytes, maximum })?)
}

/// From now on this process is asked to end (`SIGTERM`) when its parent ends, however that does; at once
/// if the parent, of this process id, has ended already. For nodes that a supervisor has started.
///
/// # Errors
///
/// The system knows no such thing; Linux does.
pub fn end_with_parent(parent: u32) -> io::Result<()> {
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{Signal, getppid, set_parent_process_death_signal};

        set_parent_process_death_signal(Some(Signal::TERM))?;
        let is_there = getppid().is_some_and(|pid| pid.as_raw_nonzero().get() as u32 == parent);
        if !is_there {
            process::exit(128 + Signal::TERM.as_raw());
        }
        Ok(())
    }
    #[cfg(not(target_os = "linux"))]
    {
        let _ = parent;
        Err(io::ErrorKind::Unsupported.into())
    }
}

/// The memory of this machine in bytes, where the system tells it.
pub fn machine_memory() -> Option<u64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let total = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kibibytes: u64 = total.split_whitespace().next()?.parse().ok()?;
    Some(kibibytes * 1024)
}

#[cfg(test)]
mod tests {
    use std::os::unix::process::ExitStatusExt;

    use rustix::process::Signal;

    use super::*;

    const IS_CHILD: &str = "ROS_RUNTIME_TEST_IS_CHILD";

    /// Runs `work`, which should end the process, in a process of its own: `test` is the calling test,
    /// which this executes again there.
    fn in_child(test: &str, work: impl FnOnce()) -> process::Output {
        if std::env::var_os(IS_CHILD).is_some() {
            work();
            process::exit(0);
        }
        let own = std::env::current_exe().unwrap();
        let test = format!("failure::tests::{test}");
        let mut child = process::Command::new(own);
        child.args(["--exact", &test, "--nocapture"]).env(IS_CHILD, "1").output().unwrap()
    }

    #[test]
    fn a_panic_in_any_thread_ends_the_process() {
        let output = in_child("a_panic_in_any_thread_ends_the_process", || {
            end_on_panic();
            let _ = std::thread::spawn(|| panic!("as it should")).join();
        });
        assert_eq!(output.status.code(), Some(PANICKED), "{output:?}");
    }

    #[test]
    fn too_much_memory_ends_the_process() {
        let output = in_child("too_much_memory_ends_the_process", || {
            limit_memory(1 << 30).unwrap();
            // black_box: memory that is not used would not be allocated.
            let _ = std::thread::spawn(|| drop(std::hint::black_box(vec![1u8; 1 << 31]))).join();
        });
        assert_eq!(output.status.signal(), Some(Signal::ABORT.as_raw()), "{output:?}");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains("memory allocation of 2147483648 bytes failed"), "{said}");
    }

    #[test]
    fn a_limit_is_never_raised() {
        let before = getrlimit(Resource::Data);
        let most = 1 << 50;
        limit_memory(most).unwrap();
        limit_memory(2 * most).unwrap();
        let expected = before.current.map_or(most, |current| current.min(most));
        assert_eq!(getrlimit(Resource::Data).current, Some(expected));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_memory_of_the_machine_is_that_of_the_system() {
        // sysinfo(2) counts in units; /proc/meminfo, which is read here, in kibibytes.
        let info = rustix::system::sysinfo();
        let total = info.totalram as u64 * u64::from(info.mem_unit);
        assert_eq!(machine_memory(), Some(total / 1024 * 1024));
    }
}
