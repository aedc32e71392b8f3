//! Pipelines, made when they are first needed, and the recording of a pass; what passes bind is twin of
//! `shaders/method/driver/readings.wgsl`, of `shaders/method/driver/scans.wgsl` and of `shaders/method/driver/updates.wgsl`.

use super::Options;
use super::device::Device;
use super::shader::{self, Kernel};
use crate::binning::snap::Footprint;
use crate::geometry::layout::{BROAD, Cone, NARROW_BEAM, WIDE};
use crate::method::{self, Method, Unit};
use crate::{Error, Result};
use std::collections::BTreeMap;

/// Bindings, in the order of `shaders/geometry/layout.wgsl`: uniform, then storage, read-only or not.
const BINDINGS: [Option<bool>; 8] =
    [None, Some(true), Some(true), Some(true), Some(false), Some(false), Some(false), Some(true)];

/// What a batch's readings ask of a kernel; less is faster, on software adapters above all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Needs {
    /// One reaches farther than 1024 cells: membership takes 64 bits.
    pub wide: bool,
    /// One has a β of more than 22.5°: another way to its angle.
    pub broad: bool,
    /// One is narrow: a band beside its wedge.
    pub narrow: bool,
}

impl Needs {
    /// Of these readings.
    pub fn of(cones: &[Cone]) -> Needs {
        let flags = cones.iter().fold(0, |flags, c| flags | c.flags);
        Needs { wide: flags & WIDE != 0, broad: flags & BROAD != 0, narrow: flags & NARROW_BEAM != 0 }
    }
}

/// A pipeline: the method, its kernel, what its readings ask, its variant.
pub type Key = (&'static str, Kernel, Needs, bool, String);

/// The pipeline of a method's kernel.
pub fn key(method: &dyn Method, kernel: Kernel, needs: Needs) -> Key {
    (method::name(method), kernel, needs, method.variant().is_some_and(|v| v.1), method.declarations())
}

/// The WGSL overrides of a kernel, with their values.
fn overrides(
    method: &dyn Method,
    kernel: Kernel,
    needs: Needs,
    staged: bool,
) -> impl Iterator<Item = (&'static str, bool)> {
    let (unit, looks) = (method.unit(), kernel != Kernel::Sum);
    let parts = (!looks).then_some(("STAGED", staged));
    let variant = method.variant().filter(|_| looks);
    let cones = (unit != Unit::Scan && looks).then_some([("BROAD_BEAMS", needs.broad), ("NARROW_BEAMS", needs.narrow)]);
    // A cone in 32 bits, not its axis alone.
    let apart = staged && !needs.wide && method.footprint() != Footprint::Axis;
    let lists = (unit == Unit::Reading && looks).then_some([("STAGED", staged), ("TOLD_APART", apart)]);
    variant.into_iter().chain(parts).chain(cones.into_iter().flatten()).chain(lists.into_iter().flatten())
}

/// The pipelines, and the one layout of their bindings.
pub struct Passes {
    layout: wgpu::BindGroupLayout,
    pipelines: BTreeMap<Key, wgpu::ComputePipeline>,
    options: Options,
}

impl Passes {
    /// None yet.
    pub fn new(device: &Device, options: &Options) -> Passes {
        let entry = |(binding, storage): (usize, &Option<bool>)| wgpu::BindGroupLayoutEntry {
            binding: binding as u32,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: match storage {
                    None => wgpu::BufferBindingType::Uniform,
                    Some(read_only) => wgpu::BufferBindingType::Storage { read_only: *read_only },
                },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let entries: Vec<_> = BINDINGS.iter().enumerate().map(entry).collect();
        let layout = device.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("every pass"),
            entries: &entries,
        });
        Passes { layout, pipelines: BTreeMap::new(), options: options.clone() }
    }

    /// How many times four cells a thread owns.
    fn groups(&self, device: &Device, method: &str, needs: Needs) -> u32 {
        let suits = || match (device.found.software, needs.wide) {
            (false, _) => 1,
            // 64 bits take more registers.
            (true, true) => 2,
            (true, false) => method::entry(method).map_or(1, |e| e.groups),
        };
        self.options.groups.unwrap_or_else(suits).clamp(1, 16).next_power_of_two()
    }

    /// Makes a pipeline that is not there yet.
    pub fn prepare(&mut self, device: &Device, method: &dyn Method, kernel: Kernel, needs: Needs) -> Result<()> {
        let key = key(method, kernel, needs);
        if self.pipelines.contains_key(&key) {
            return Ok(());
        }
        let label = format!("{} {}", key.0, kernel.name());
        let mut source = shader::source(method, kernel, needs.wide, self.groups(device, key.0, needs));
        for (from, to) in &self.options.patches {
            source = source.replace(from, to);
        }
        let staged = self.options.stages(&device.found);
        let constants: Vec<_> =
            overrides(method, kernel, needs, staged).map(|(name, on)| (name, f64::from(on))).collect();
        let scope = device.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let module = device.module(&label, source);
        let layout = device.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(&label),
            bind_group_layouts: &[Some(&self.layout)],
            immediate_size: 0,
        });
        let pipeline = device.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(&label),
            layout: Some(&layout),
            module: &module,
            entry_point: Some(kernel.name()),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &constants,
                // What is read was written before.
                zero_initialize_workgroup_memory: false,
            },
            cache: None,
        });
        if let Some(e) = pollster::block_on(scope.pop()) {
            return Err(Error::NoAdapter(format!("{} refuses the kernel {label}: {e}", device.found)));
        }
        self.pipelines.insert(key, pipeline);
        Ok(())
    }

    /// Records a pass over `groups` workgroups; `bound` in the order of the bindings. A chunk has at most 4096 tiles, and a
    /// batch at most 64 readings for each group of a dispatch, so one axis suffices.
    #[allow(clippy::too_many_arguments, reason = "what a dispatch takes")]
    pub fn record(
        &self,
        device: &Device,
        encoder: &mut wgpu::CommandEncoder,
        key: Key,
        bound: [wgpu::BufferBinding; 8],
        groups: u32,
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites>,
    ) {
        let Some(pipeline) = self.pipelines.get(&key) else { return };
        let entries: Vec<_> = (0..)
            .zip(bound)
            .map(|(binding, b)| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::Buffer(b) })
            .collect();
        let label = Some(key.1.name());
        let group = device.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label,
            layout: &self.layout,
            entries: &entries,
        });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(groups, 1, 1);
    }
}
