//! Finding an adapter and opening its device.

use super::vulkan::Drivers;
use crate::{Error, Result};
use std::sync::OnceLock;

/// What to say where there is no adapter.
pub const REMEDY: &str = "install a GPU driver with Vulkan, or the software adapter (Debian and Ubuntu: apt-get install \
     mesa-vulkan-drivers libvulkan1), or use --backend cpu";

/// An adapter, as `doctor` and reports show it.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Found {
    /// Its name.
    pub name: String,
    /// Vulkan, Metal, Dx12.
    pub api: String,
    /// Its driver and the driver's version.
    pub driver: String,
    /// Whether it is a processor in disguise.
    pub software: bool,
    /// Largest buffer that a kernel can bind, bytes.
    pub binding: u64,
    /// Largest buffer, bytes.
    pub buffer: u64,
    /// Workgroups along one axis of a dispatch.
    pub workgroups: u32,
    /// Workgroup memory, bytes.
    pub workgroup_memory: u32,
}

impl std::fmt::Display for Found {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let software = if self.software { ", software" } else { "" };
        write!(f, "{} ({}{software}; {})", self.name, self.api, self.driver)
    }
}

/// One for the process: a driver may give out no more than some tens.
fn instance() -> &'static wgpu::Instance {
    static INSTANCE: OnceLock<wgpu::Instance> = OnceLock::new();
    INSTANCE.get_or_init(|| wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle()))
}

fn describe(adapter: &wgpu::Adapter) -> Found {
    let (info, limits) = (adapter.get_info(), adapter.limits());
    Found {
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
pub fn list() -> Vec<Found> {
    ranked().iter().map(describe).collect()
}

/// Opens the best adapter with all of its limits. `hardware`: a software adapter is not good enough.
pub fn open(hardware: bool) -> Result<(Found, wgpu::Device, wgpu::Queue)> {
    let none = |what: &str| Error::NoAdapter(format!("{what}: {REMEDY}"));
    let missing = || Error::NoAdapter(format!("there is no GPU adapter: {}", Drivers::look().why_none()));
    let adapter = ranked().into_iter().next().ok_or_else(missing)?;
    let found = describe(&adapter);
    if hardware && found.software {
        return Err(none(&format!("the only adapter is {found}")));
    }
    let limits = adapter.limits();
    if limits.max_storage_buffers_per_shader_stage < 7 || limits.max_compute_invocations_per_workgroup < 64 {
        return Err(none(&format!(
            "{found} binds {} storage buffers, 7 are needed",
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
        .map_err(|e| none(&format!("{found} gives no device ({e})")))?;
    Ok((found, device, queue))
}
