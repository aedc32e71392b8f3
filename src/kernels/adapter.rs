//! GPU adapters, described without the GPU backend.

/// What a message advises where there is no adapter.
pub const REMEDY: &str = "install a GPU driver with Vulkan, or the software adapter (Debian and Ubuntu: apt-get install \
     mesa-vulkan-drivers libvulkan1), or use --backend cpu";

/// A GPU adapter, as `doctor` and reports show it.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct AdapterInfo {
    /// Its name.
    pub name: String,
    /// Vulkan, Metal, Dx12.
    pub api: String,
    /// Its driver and the driver's version.
    pub driver: String,
    /// Whether it runs on the processor (Mesa's lavapipe, say).
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

impl std::fmt::Display for AdapterInfo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let software = if self.software { ", software" } else { "" };
        write!(f, "{} ({}{software}; {})", self.name, self.api, self.driver)
    }
}
