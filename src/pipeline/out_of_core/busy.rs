//! How long the stages of a round had work.

use std::time::{Duration, Instant};

/// Seconds that the stages of a round had work.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Busy {
    /// Reading and binning ahead.
    pub read: f64,
    /// Running kernels.
    pub kernels: f64,
    /// Taking finished chunks.
    pub take: f64,
}

/// The time of a stage's thread, without the time that it waits for another stage.
pub(super) struct Clock {
    started: Instant,
    waited: Duration,
}

impl Clock {
    pub fn start() -> Clock {
        Clock { started: Instant::now(), waited: Duration::ZERO }
    }

    /// Runs what only waits for another stage.
    pub fn wait<T>(&mut self, run: impl FnOnce() -> T) -> T {
        let started = Instant::now();
        let done = run();
        self.waited += started.elapsed();
        done
    }

    /// Seconds of work so far.
    pub fn worked(&self) -> f64 {
        (self.started.elapsed() - self.waited).as_secs_f64()
    }
}
