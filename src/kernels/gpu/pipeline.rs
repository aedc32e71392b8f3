//! Making one compute pipeline, with an explicit layout of its bindings.

use super::device::Device;
use super::options::Patch;
use crate::kernels::bindings::{Access, Binding};

/// A compute pipeline and the layout of its bindings.
#[derive(Debug, Clone)]
pub struct Pipeline {
    /// The pipeline.
    pub pipeline: wgpu::ComputePipeline,
    /// Its group 0.
    pub layout: wgpu::BindGroupLayout,
}

/// What a pipeline is made of.
pub struct Description<'a> {
    /// Its label.
    pub label: &'a str,
    /// The module.
    pub module: &'a wgpu::ShaderModule,
    /// The entry point.
    pub entry_point: &'a str,
    /// The bindings of group 0.
    pub bindings: &'a [Binding],
    /// The values of the module's `override`s.
    pub constants: &'a [(&'a str, f64)],
}

impl Pipeline {
    /// Makes a pipeline. The device reports a kernel that it refuses to the error scope around this call.
    pub fn new(device: &Device, description: &Description) -> Pipeline {
        let Description { label, module, entry_point, bindings, constants } = *description;
        let label = Some(label);
        let entries: Vec<_> = bindings.iter().map(layout_entry).collect();
        let descriptor = wgpu::BindGroupLayoutDescriptor { label, entries: &entries };
        let group = device.device.create_bind_group_layout(&descriptor);
        let layout = device.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &[Some(&group)],
            immediate_size: 0,
        });
        let pipeline = device.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: Some(&layout),
            module,
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants,
                // Kernels read nothing of it that they have not written.
                zero_initialize_workgroup_memory: false,
            },
            cache: None,
        });
        Pipeline { pipeline, layout: group }
    }
}

fn layout_entry(binding: &Binding) -> wgpu::BindGroupLayoutEntry {
    let ty = match binding.access {
        Access::Uniform => wgpu::BufferBindingType::Uniform,
        Access::Read => wgpu::BufferBindingType::Storage { read_only: true },
        Access::ReadWrite => wgpu::BufferBindingType::Storage { read_only: false },
    };
    let min_binding_size = std::num::NonZero::new(binding.stride);
    wgpu::BindGroupLayoutEntry {
        binding: binding.number,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size },
        count: None,
    }
}

/// A source with a test's changes.
pub fn patched(source: String, patches: &[Patch]) -> String {
    patches.iter().fold(source, |source, (from, to)| source.replace(from, to))
}
