//! The busy time of each stage of a round.

use std::time::{Duration, Instant};

/// Seconds that each stage of a round had work; what it waited for other stages is left out.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StageTimes {
    /// Reading and binning ahead.
    pub read: f64,
    /// Running kernels.
    pub kernels: f64,
    /// Making the layers of finished chunks, and their sink.
    pub take: f64,
}

/// A clock of the work of a stage's thread, which leaves out the time that the thread waits for another stage.
pub(super) struct StageClock {
    started: Instant,
    waited: Duration,
}

impl StageClock {
    pub fn start() -> StageClock {
        StageClock { started: Instant::now(), waited: Duration::ZERO }
    }

    /// Runs a function that only waits for another stage.
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
