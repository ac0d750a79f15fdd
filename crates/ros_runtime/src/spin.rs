//! Waiting without falling asleep at once.
//!
//! A thread that sleeps is woken by the kernel, on a core that may have gone to sleep itself: tens of
//! microseconds, more than all the work of a message. A service call waits for four threads in turn.
//! So a waiting thread stays awake for a moment, in which it leaves its core to whoever wants it,
//! and sleeps only if nothing has come by then.

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

/// How long a node's thread stays awake: longer than a round trip on one machine takes.
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
    /// Returns once it is woken; until `end` it stays awake.
    fn wait_until(&self, end: Instant) {
        while !self.woken.load(SeqCst) {
            if Instant::now() < end {
                // Not a mere spin: DDS's own threads may need this core.
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

/// Runs a future on this thread, which stays awake for the window when it waits.
///
/// A wait is mostly as long as the one before. So after one that was longer than the window the
/// thread sleeps at once, until they are shorter again: a node that is asked now and then costs
/// nothing, and one that is asked all the time answers soon.
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
        // Before the poll: what wakes during it counts.
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

    /// Wakes from another thread, early and late, with a window that is long, short or none.
    #[test]
    fn nothing_that_wakes_is_missed() {
        for window in [Duration::ZERO, Duration::from_micros(20), Duration::from_secs(5)] {
            for pause in [Duration::ZERO, Duration::from_micros(20), Duration::from_millis(3)] {
                let (sender, receiver) = futures::channel::mpsc::unbounded();
                let other = thread::spawn(move || {
                    for number in 0..100 {
                        thread::sleep(pause);
                        sender.unbounded_send(number).unwrap();
                    }
                });
                let received: Vec<i32> = block_on(window, futures::StreamExt::collect(receiver));
                assert!(received.into_iter().eq(0..100));
                other.join().unwrap();
            }
        }
    }
}
