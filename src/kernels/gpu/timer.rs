//! Time that each kind of pass takes on the device, by the device's own time stamps.

use super::device::Device;
use crate::Result;
use std::collections::BTreeMap;
use wgpu::BufferUsages as Usage;

/// The most passes between two reads.
const MOST: u32 = 1024;
const BYTES: u64 = size_of::<u64>() as u64;

/// Time stamps not read yet, and the seconds so far.
pub struct Timer {
    stamps: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// The passes whose stamps are not read yet.
    passes: Vec<&'static str>,
    /// Whether there were more passes than stamps: the sums would be too small.
    overrun: bool,
    seconds: BTreeMap<&'static str, f64>,
}

impl Timer {
    /// `None` where the device has no clock.
    pub fn new(device: &Device) -> Option<Timer> {
        device.device.features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| Timer {
            stamps: device.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("stamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * MOST,
            }),
            resolved: device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("stamps"),
                size: 2 * u64::from(MOST) * BYTES,
                usage: Usage::QUERY_RESOLVE | Usage::COPY_SRC,
                mapped_at_creation: false,
            }),
            passes: Vec::new(),
            overrun: false,
            seconds: BTreeMap::new(),
        })
    }

    /// Where a pass writes the stamps of its begin and its end.
    pub fn writes(&mut self, pass: &'static str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let first = 2 * self.passes.len() as u32;
        if first >= 2 * MOST {
            self.overrun = true;
            return None;
        }
        self.passes.push(pass);
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.stamps,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        })
    }

    /// Waits for the stamps and adds them up.
    pub fn read(&mut self, device: &Device) -> Result<()> {
        if self.passes.is_empty() {
            return Ok(());
        }
        let mut encoder = device.encoder();
        encoder.resolve_query_set(&self.stamps, 0..2 * self.passes.len() as u32, &self.resolved, 0);
        device.submit(&mut encoder);
        let words = device.read(&self.resolved, 2 * self.passes.len() as u64 * BYTES)?;
        let stamp = |k: usize| u64::from(words[2 * k + 1]) << 32 | u64::from(words[2 * k]);
        let tick = f64::from(device.queue.get_timestamp_period()) * 1e-9;
        for (k, pass) in self.passes.drain(..).enumerate() {
            let ticks = stamp(2 * k + 1).saturating_sub(stamp(2 * k));
            *self.seconds.entry(pass).or_default() += ticks as f64 * tick;
        }
        Ok(())
    }

    /// Seconds of each kind of pass, by name; empty if some passes had no stamps.
    pub fn seconds(self) -> Vec<(&'static str, f64)> {
        if self.overrun { Vec::new() } else { self.seconds.into_iter().collect() }
    }
}
