//! Finding an adapter and opening its device.

use crate::kernels::adapter::{AdapterInfo, REMEDY};
use crate::kernels::vulkan::Drivers;
use crate::{Error, Result};
use std::sync::OnceLock;

/// The process's one instance: a driver may give out no more than some tens.
fn instance() -> &'static wgpu::Instance {
    static INSTANCE: OnceLock<wgpu::Instance> = OnceLock::new();
    INSTANCE.get_or_init(|| wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle()))
}

fn describe(adapter: &wgpu::Adapter) -> AdapterInfo {
    let (info, limits) = (adapter.get_info(), adapter.limits());
    AdapterInfo {
        name: info.name,
        api: format!("{:?}", info.backend),
        driver: format!("{} {}", info.driver, info.driver_info).trim().into(),
        software: info.device_type == wgpu::DeviceType::Cpu,
        binding: limits.max_storage_buffer_binding_size,
        buffer: limits.max_buffer_size,
        workgroups: limits.max_compute_workgroups_per_dimension,
        workgroup_memory: limits.max_compute_workgroup_storage_size,
    }
}

/// Discrete before integrated before others before software; then in the system's order.
fn rank(adapter: &wgpu::Adapter) -> u8 {
    match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu | wgpu::DeviceType::Other => 2,
        wgpu::DeviceType::Cpu => 3,
    }
}

fn ranked() -> Vec<wgpu::Adapter> {
    let mut adapters = pollster::block_on(instance().enumerate_adapters(wgpu::Backends::all()));
    adapters.retain(|a| {
        let flags = a.get_downlevel_capabilities().flags;
        flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) && a.get_info().backend != wgpu::Backend::Noop
    });
    adapters.sort_by_key(rank);
    adapters
}

/// Every adapter that can compute, the best first.
pub(in crate::kernels) fn list() -> Vec<AdapterInfo> {
    ranked().iter().map(describe).collect()
}

/// Opens the best adapter with all of its limits; with `hardware` a software adapter is refused.
///
/// # Errors
/// [`Error::NoAdapter`] where there is none, or it can't run the kernels.
pub fn open(hardware: bool) -> Result<(AdapterInfo, wgpu::Device, wgpu::Queue)> {
    let none = |what: &str| Error::NoAdapter(format!("{what}: {REMEDY}"));
    let missing = || Error::NoAdapter(format!("there is no GPU adapter: {}", Drivers::look().why_none()));
    let adapter = ranked().into_iter().next().ok_or_else(missing)?;
    let info = describe(&adapter);
    if hardware && info.software {
        return Err(none(&format!("the only adapter is {info}")));
    }
    let limits = adapter.limits();
    if limits.max_storage_buffers_per_shader_stage < 7 || limits.max_compute_invocations_per_workgroup < 64 {
        return Err(none(&format!(
            "{info} binds {} storage buffers, 7 are needed",
            limits.max_storage_buffers_per_shader_stage
        )));
    }
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("echogrid"),
        required_limits: limits,
        // For measuring; nothing needs it.
        required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
        ..Default::default()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
        .map_err(|e| none(&format!("{info} gives no device ({e})")))?;
    Ok((info, device, queue))
}
