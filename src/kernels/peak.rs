//! The peak rates of a processor (its roofline), against which throughput is compared. Kernels that only compute, or only copy, measure
//! them; twins of `shaders/kernels/peak/*.wgsl`.

use crate::Result;
use fearless_simd::{Level, dispatch};
use rayon::prelude::*;
use serde::Serialize;
use std::hint::black_box;
use std::time::Instant;

/// The highest rates measured on a backend.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Peaks {
    /// f32 operations a second, a fused multiplication and addition counted as two.
    pub flop: f64,
    /// 32-bit integer operations a second, a multiplication and an addition counted as two.
    pub int: f64,
    /// Bytes a second of a copy, read and written ones.
    pub bytes: f64,
}

/// Independent chains of operations in each thread: enough to hide the latency of any operation.
const CHAINS: usize = 128;
const STEPS: usize = 400_000;
/// Bytes that a thread copies: more than the caches hold.
const COPY: usize = 64 << 20;

/// Runs are repeated for at least this long, seconds: a processor that was idle or is shared needs a while to reach its peak.
const LONG_ENOUGH: f64 = 0.25;

/// Seconds of the fastest of at least five runs.
pub(super) fn fastest(mut run: impl FnMut() -> Result<()>) -> Result<f64> {
    let (begun, mut runs, mut best) = (Instant::now(), 0, f64::INFINITY);
    while runs < 5 || begun.elapsed().as_secs_f64() < LONG_ENOUGH {
        let started = Instant::now();
        run()?;
        best = best.min(started.elapsed().as_secs_f64());
        runs += 1;
    }
    Ok(best)
}

#[inline(always)]
fn fused(values: &mut [f32; CHAINS], x: f32, y: f32) {
    for _ in 0..STEPS {
        for v in values.iter_mut() {
            *v = v.mul_add(x, y);
        }
    }
}

#[inline(always)]
fn whole(values: &mut [i32; CHAINS], x: i32, y: i32) {
    for _ in 0..STEPS {
        for v in values.iter_mut() {
            *v = v.wrapping_mul(x).wrapping_add(y);
        }
    }
}

/// The peak rates of so many threads together, in the thread pool of the caller.
pub fn cpu(threads: usize) -> Result<Peaks> {
    let level = Level::new();
    let each = |work: &(dyn Fn() + Sync)| (0..threads).into_par_iter().for_each(|_| work());
    let steps = (2 * CHAINS * STEPS * threads) as f64;
    let flop = fastest(|| {
        each(&|| {
            let mut values = black_box([1.0f32; CHAINS]);
            let (x, y) = black_box((0.999, 0.001));
            dispatch!(level, _simd => fused(&mut values, x, y));
            black_box(values);
        });
        Ok(())
    })?;
    let int = fastest(|| {
        each(&|| {
            let mut values = black_box([1i32; CHAINS]);
            let (x, y) = black_box((3, 7));
            dispatch!(level, _simd => whole(&mut values, x, y));
            black_box(values);
        });
        Ok(())
    })?;
    let mut buffers: Vec<(Vec<u8>, Vec<u8>)> = (0..threads).map(|_| (vec![1; COPY], vec![0; COPY])).collect();
    let copy = fastest(|| {
        buffers.par_iter_mut().for_each(|(from, to)| to.copy_from_slice(black_box(from)));
        Ok(())
    })?;
    Ok(Peaks { flop: steps / flop, int: steps / int, bytes: (2 * COPY * threads) as f64 / copy })
}
