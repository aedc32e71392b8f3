//! The adapter's ceilings: three small kernels that only compute, or only copy.

use super::device::Device;
use super::shader::each;
use crate::kernels::ceiling::{Ceilings, fastest};
use crate::{Error, Result};

const FMA: &str = include_str!("../../../shaders/kernels/ceiling/fma.wgsl");
const INT: &str = include_str!("../../../shaders/kernels/ceiling/int.wgsl");
const COPY: &str = include_str!("../../../shaders/kernels/ceiling/copy.wgsl");

/// Times that a computing thread's step stands in its loop: what the loop itself takes is to be little.
const UNROLLED: u32 = 16;
/// Operations of a computing thread: sixteen values, two each.
const OPERATIONS: f64 = 128.0 * UNROLLED as f64 * 32.0;
/// Bytes that are copied on hardware, more than its caches hold, and on a software adapter.
const BYTES: [u64; 2] = [512 << 20, 64 << 20];
/// Fewer show nothing.
const LEAST: u64 = 1 << 20;
/// Vectors that a thread copies.
const COPIES: u64 = 8;
/// Seconds that a measured submission should take at least: its start and its end cost some.
const LONG: f64 = 0.02;

/// Measures them.
pub fn ceilings(device: &Device) -> Result<Ceilings> {
    let mut bytes = BYTES[usize::from(device.found.software)].min(device.bindable() as u64);
    let [source, sink] = loop {
        // A small card has less free.
        let scope = device.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let buffers = ["ceiling source", "ceiling sink"].map(|label| device.zeros(label, bytes));
        match pollster::block_on(scope.pop()) {
            Some(_) if bytes > LEAST => bytes /= 2,
            _ => break buffers,
        }
    };
    let rate = |source_code: &str, groups: u32, work: f64| -> Result<f64> {
        let pipeline = pipeline(device, source_code)?;
        let group = device.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("ceiling"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: source.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: sink.as_entire_binding() },
            ],
        });
        let run = |times: u32| {
            let mut encoder = device.encoder();
            for _ in 0..times {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                pass.set_pipeline(&pipeline);
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
    let groups = device.found.workgroups.min(4096);
    let threads = f64::from(groups) * 64.0;
    let copied = ((bytes / 16 / 64 / COPIES) as u32).min(device.found.workgroups);
    Ok(Ceilings {
        flop: rate(FMA, groups, threads * OPERATIONS)?,
        int: rate(INT, groups, threads * OPERATIONS)?,
        bytes: rate(COPY, copied, f64::from(copied) * 64.0 * 32.0 * COPIES as f64)?,
    })
}

fn pipeline(device: &Device, source: &str) -> Result<wgpu::ComputePipeline> {
    let scope = device.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let module = device.module("ceiling", each(source, UNROLLED));
    let kind = |read_only| wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only },
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let entry = |binding, read_only| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: kind(read_only),
        count: None,
    };
    let bindings = device.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("ceiling"),
        entries: &[entry(0, true), entry(1, false)],
    });
    let layout = device.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("ceiling"),
        bind_group_layouts: &[Some(&bindings)],
        immediate_size: 0,
    });
    let pipeline = device.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("ceiling"),
        layout: Some(&layout),
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    match pollster::block_on(scope.pop()) {
        Some(e) => Err(Error::NoAdapter(format!("{} refuses a kernel: {e}", device.found))),
        None => Ok(pipeline),
    }
}
