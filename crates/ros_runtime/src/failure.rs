//! Makes a failing node exit with an error, so that its supervisor can restart it.
//!
//! A Rust process survives a panic in a thread other than the main thread. A node whose DDS threads
//! have panicked would neither receive nor send messages, but would look alive. In addition,
//! RustDDS 0.15 without the patches in `patches/rustdds` trusts the sizes that a packet claims:
//! some 60-byte packets make it allocate gigabytes. `docs/reliability.md` lists these packets.
//!
//! # Examples
//!
//! ```no_run
//! use ros_runtime::failure::{exit_on_panic, limit_memory};
//!
//! exit_on_panic();
//! limit_memory(1 << 30)?; // 1 GiB
//! # Ok::<(), std::io::Error>(())
//! ```

use std::{fs, io, panic, process};

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// The exit status after a panic, the same as if the main thread of a Rust program panics.
const PANICKED: i32 = 101;

/// Makes a panic in any thread exit the process with status 101 after the current panic hook has
/// reported the panic.
///
/// # Panics
///
/// Panics if the calling thread is panicking.
pub fn exit_on_panic() {
    let report = panic::take_hook();
    panic::set_hook(Box::new(move |panic| {
        report(panic);
        // The logger is not used: it publishes over DDS, which may be the component that failed.
        eprintln!("a thread panicked (see above); exiting");
        process::exit(PANICKED);
    }));
}

/// Limits the data memory of this process to `bytes`. An allocation beyond the limit aborts the
/// process (`SIGABRT`). If a stricter limit is already set, it is kept.
///
/// # Errors
///
/// Returns an error if the operating system rejects the limit.
pub fn limit_memory(bytes: u64) -> io::Result<()> {
    let Rlimit { current, maximum } = getrlimit(Resource::Data);
    // The operator may have set a stricter limit.
    let bytes = [Some(bytes), current, maximum].into_iter().flatten().min();
    Ok(setrlimit(Resource::Data, Rlimit { current: bytes, maximum })?)
}

/// Makes the kernel send `SIGTERM` to this process when its parent ends, even if the parent is
/// killed.
///
/// A node that a supervisor starts calls this function with the supervisor's process ID. If that
/// process has already ended, this process exits immediately with status 143.
///
/// # Errors
///
/// Returns an error on operating systems other than Linux, which do not support this.
pub fn exit_with_parent(parent: u32) -> io::Result<()> {
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{Signal, getppid, set_parent_process_death_signal};

        set_parent_process_death_signal(Some(Signal::TERM))?;
        let is_alive = getppid().is_some_and(|pid| pid.as_raw_nonzero().get() as u32 == parent);
        if !is_alive {
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

/// Returns the total memory of this machine in bytes, or `None` if `/proc/meminfo` does not provide
/// it.
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

    /// Runs `work`, which is expected to end the process, in a child process that runs only the
    /// calling test, named `test`.
    fn in_child(test: &str, work: impl FnOnce()) -> process::Output {
        if std::env::var_os(IS_CHILD).is_some() {
            work();
            process::exit(0);
        }
        let test = format!("failure::tests::{test}");
        let mut child = process::Command::new(std::env::current_exe().unwrap());
        child.args(["--exact", &test, "--nocapture"]).env(IS_CHILD, "1").output().unwrap()
    }

    #[test]
    fn a_panic_in_any_thread_exits_the_process() {
        let output = in_child("a_panic_in_any_thread_exits_the_process", || {
            exit_on_panic();
            let _ = std::thread::spawn(|| panic!("expected by this test")).join();
        });
        assert_eq!(output.status.code(), Some(PANICKED), "{output:?}");
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(message.contains("a thread panicked (see above); exiting"), "{message}");
    }

    #[test]
    fn an_allocation_beyond_the_limit_aborts_the_process() {
        let output = in_child("an_allocation_beyond_the_limit_aborts_the_process", || {
            limit_memory(1 << 30).unwrap();
            // Without black_box, the compiler would remove the unused allocation.
            let _ = std::thread::spawn(|| drop(std::hint::black_box(vec![1u8; 1 << 31]))).join();
        });
        assert_eq!(output.status.signal(), Some(Signal::ABORT.as_raw()), "{output:?}");
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(message.contains("memory allocation of 2147483648 bytes failed"), "{message}");
    }

    #[test]
    fn a_limit_is_never_raised() {
        let before = getrlimit(Resource::Data);
        let limit = 1 << 50;
        limit_memory(limit).unwrap();
        limit_memory(2 * limit).unwrap();
        let expected = before.current.map_or(limit, |current| current.min(limit));
        assert_eq!(getrlimit(Resource::Data).current, Some(expected));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_machine_memory_matches_sysinfo() {
        // /proc/meminfo counts kibibytes; sysinfo(2) uses the unit `mem_unit`.
        let info = rustix::system::sysinfo();
        let total = info.totalram as u64 * u64::from(info.mem_unit);
        assert_eq!(machine_memory(), Some(total / 1024 * 1024));
    }
}
