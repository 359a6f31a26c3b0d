//! Says that a test had nothing to run on, past the test runner, which keeps what passing tests print to itself.

use std::io::Write;

pub fn skipped(why: &str) {
    let thread = std::thread::current();
    let line = format!("SKIPPED {}: {why}\n", thread.name().unwrap_or("a test"));
    // one write, so that lines of several tests stay whole; nothing is lost where nobody listens
    let _ = std::io::stderr().write_all(line.as_bytes());
}
