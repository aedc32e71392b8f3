//! The adapter's peak rates (the roofline), measured by three small kernels that only compute, or only copy.

use super::device::Device;
use super::pipeline::{Description, Pipeline};
use crate::kernels::bindings::{Access, Binding};
use crate::kernels::peak::{Peaks, fastest};
use crate::kernels::shader::unroll;
use crate::{Error, Result};

const FMA: &str = include_str!("../../../shaders/kernels/peak/fma.wgsl");
const INT: &str = include_str!("../../../shaders/kernels/peak/int.wgsl");
const COPY: &str = include_str!("../../../shaders/kernels/peak/copy.wgsl");

/// How often a computing thread's step is repeated in its loop, so that the loop itself costs little.
const UNROLLED: u32 = 16;
/// Operations of a computing thread: two for each of sixteen values in a step.
const OPERATIONS: f64 = 128.0 * UNROLLED as f64 * 32.0;
/// Bytes that are copied on hardware, more than its caches hold, and on a software adapter.
const BYTES: [u64; 2] = [512 << 20, 64 << 20];
/// The fewest bytes worth copying.
const LEAST: u64 = 1 << 20;
/// Vectors that a thread copies.
const COPIES: u64 = 8;
/// Seconds that a measured submission takes at least, so that its start and end cost little.
const LONG: f64 = 0.02;

/// Measures the peak rates.
pub fn peaks(device: &Device) -> Result<Peaks> {
    let mut bytes = BYTES[usize::from(device.info.software)].min(device.bindable() as u64);
    let [source, sink] = loop {
        // A small card has less free.
        let scope = device.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let buffers = ["peak source", "peak sink"].map(|label| device.zeros(label, bytes));
        match pollster::block_on(scope.pop()) {
            Some(_) if bytes > LEAST => bytes /= 2,
            _ => break buffers,
        }
    };
    let rate = |source_code: &str, groups: u32, work: f64| -> Result<f64> {
        let pipeline = pipeline(device, source_code)?;
        let group = device.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("peak"),
            layout: &pipeline.layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: source.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: sink.as_entire_binding() },
            ],
        });
        let run = |times: u32| {
            let mut encoder = device.encoder();
            for _ in 0..times {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                pass.set_pipeline(&pipeline.pipeline);
                pass.set_bind_group(0, &group, &[]);
                pass.dispatch_workgroups(groups, 1, 1);
            }
            let submitted = device.submit(&mut encoder);
            device.wait(Some(submitted))
        };
        // As often as it takes to be long: a fast card does one in microseconds.
        let once = fastest(|| run(1))?;
        let times = (LONG / once.max(1e-6)).ceil().clamp(1.0, 4096.0) as u32;
        Ok(work * f64::from(times) / fastest(|| run(times))?)
    };
    let groups = device.info.workgroups.min(4096);
    let threads = f64::from(groups) * 64.0;
    let copied = ((bytes / 16 / 64 / COPIES) as u32).min(device.info.workgroups);
    Ok(Peaks {
        flop: rate(FMA, groups, threads * OPERATIONS)?,
        int: rate(INT, groups, threads * OPERATIONS)?,
        bytes: rate(COPY, copied, f64::from(copied) * 64.0 * 32.0 * COPIES as f64)?,
    })
}

/// What the kernels bind.
const BINDINGS: &[Binding] = &[
    Binding { number: 0, name: "source", access: Access::Read, stride: 16 },
    Binding { number: 1, name: "sink", access: Access::ReadWrite, stride: 16 },
];

fn pipeline(device: &Device, source: &str) -> Result<Pipeline> {
    let scope = device.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let module = &device.module("peak", unroll(source, UNROLLED));
    let description = Description { label: "peak", module, entry_point: "main", bindings: BINDINGS, constants: &[] };
    let pipeline = Pipeline::new(device, &description);
    match pollster::block_on(scope.pop()) {
        Some(e) => Err(Error::NoAdapter(format!("{} refuses a kernel: {e}", device.info))),
        None => Ok(pipeline),
    }
}
