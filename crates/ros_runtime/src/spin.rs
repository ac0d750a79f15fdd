//! An executor whose thread stays awake briefly before it sleeps.
//!
//! The kernel takes tens of microseconds to wake a sleeping thread, and even longer on an idle
//! core. This is longer than processing a message takes, and a service call waits for four threads
//! in turn. A waiting thread therefore first stays awake for a short window, yielding its core to
//! other threads, and sleeps only when the window is over.

use std::{
    future::Future,
    pin::pin,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::SeqCst},
    },
    task::{Context, Poll, Wake, Waker},
    thread::{self, Thread},
    time::{Duration, Instant},
};

/// The window of a node's thread: 150 us, which is longer than a local service call takes.
pub const WINDOW: Duration = Duration::from_micros(150);

struct Signal {
    woken: AtomicBool,
    is_asleep: AtomicBool,
    thread: Thread,
}

impl Wake for Signal {
    fn wake(self: Arc<Self>) {
        self.wake_by_ref();
    }

    fn wake_by_ref(self: &Arc<Self>) {
        self.woken.store(true, SeqCst);
        if self.is_asleep.load(SeqCst) {
            self.thread.unpark();
        }
    }
}

impl Signal {
    /// Waits for a wake-up. The thread stays awake until `end` and then sleeps.
    fn wait_until(&self, end: Instant) {
        while !self.woken.load(SeqCst) {
            if Instant::now() < end {
                // Busy waiting would keep DDS's threads off this core.
                thread::yield_now();
            } else {
                self.is_asleep.store(true, SeqCst);
                while !self.woken.load(SeqCst) {
                    thread::park();
                }
                self.is_asleep.store(false, SeqCst);
            }
        }
    }
}

/// Runs a future on this thread, which stays awake for up to `window` whenever the future waits.
///
/// A wait tends to be as long as the previous one. After a wait longer than the window, the thread
/// sleeps immediately in each wait until one is shorter than the window again. This way, an idle
/// node uses no CPU time, and a busy node responds quickly.
///
/// # Panics
///
/// Panics if the future panics, or if `window` is too long to be added to an [`Instant`].
///
/// # Examples
///
/// ```
/// use ros_runtime::spin;
///
/// assert_eq!(spin::block_on(spin::WINDOW, async { 1 + 1 }), 2);
/// ```
pub fn block_on<T>(window: Duration, work: impl Future<Output = T>) -> T {
    let signal = Arc::new(Signal {
        woken: AtomicBool::new(false),
        is_asleep: AtomicBool::new(false),
        thread: thread::current(),
    });
    let waker = Waker::from(signal.clone());
    let mut context = Context::from_waker(&waker);
    let mut work = pin!(work);
    let mut last_wait = Duration::ZERO;
    loop {
        // Reset before the poll, so that a wake-up during the poll is not lost.
        signal.woken.store(false, SeqCst);
        if let Poll::Ready(result) = work.as_mut().poll(&mut context) {
            return result;
        }
        let start = Instant::now();
        signal.wait_until(if last_wait < window { start + window } else { start });
        last_wait = start.elapsed();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Another thread wakes the future within the window, after the window, and without a window.
    #[test]
    fn no_wake_up_is_lost() {
        for window in [Duration::ZERO, Duration::from_micros(20), Duration::from_secs(5)] {
            for pause in [Duration::ZERO, Duration::from_micros(20), Duration::from_millis(3)] {
                let (sender, receiver) = futures::channel::mpsc::unbounded();
                let waker = thread::spawn(move || {
                    for number in 0..100 {
                        thread::sleep(pause);
                        sender.unbounded_send(number).unwrap();
                    }
                });
                let received: Vec<i32> = block_on(window, futures::StreamExt::collect(receiver));
                assert!(received.into_iter().eq(0..100));
                waker.join().unwrap();
            }
        }
    }
}
