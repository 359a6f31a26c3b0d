//! A sign of life on a terminal for work that takes longer than a second; nothing where no person watches.

use std::sync::mpsc::{Sender, channel};
use std::thread;
use std::time::Duration;

use indicatif::ProgressBar;

use super::is_quiet;

/// Work that ends within this time shows nothing.
const QUIET: Duration = Duration::from_secs(1);
/// Time between two pictures of the sign.
const TICK: Duration = Duration::from_millis(120);

/// Shown from a second after its making until it is dropped.
pub struct Working {
    done: Option<Sender<()>>,
    thread: Option<thread::JoinHandle<()>>,
}

impl Working {
    /// Starts the clock; `what` says what is being done.
    pub fn on(what: String) -> Working {
        let (done, wait) = channel::<()>();
        let thread = thread::spawn(move || {
            // a closed channel means done
            if wait.recv_timeout(QUIET) != Err(std::sync::mpsc::RecvTimeoutError::Timeout) {
                return;
            }
            // indicatif draws on standard error, and only when that is a terminal
            if is_quiet() {
                return;
            }
            let bar = ProgressBar::new_spinner().with_message(what);
            bar.enable_steady_tick(TICK);
            let _ = wait.recv();
            bar.finish_and_clear();
        });
        Working { done: Some(done), thread: Some(thread) }
    }
}

impl Drop for Working {
    fn drop(&mut self) {
        self.done.take();
        if let Some(thread) = self.thread.take() {
            // a sign of life that failed is no reason to stop
            let _ = thread.join();
        }
    }
}
