//! Opens the Vulkan loader's and drivers' libraries to see whether they can be used. Where the loader is another, or without the
//! feature `gpu`, nothing is checked.

use std::path::Path;

pub(super) use platform::{driver, loader};

#[cfg(all(feature = "gpu", unix, not(target_os = "macos")))]
mod platform {
    use super::Path;
    use libloading::Library;

    /// Opens the Vulkan loader.
    pub fn loader() -> Result<(), String> {
        open(Path::new("libvulkan.so.1")).or_else(|why| open(Path::new("libvulkan.so")).map_err(|_| why)).map(drop)
    }

    /// Opens a driver.
    pub fn driver(path: &Path) -> Result<(), String> {
        let library = open(path)?;
        let names: [&[u8]; 2] = [b"vk_icdGetInstanceProcAddr\0", b"vkGetInstanceProcAddr\0"];
        // SAFETY: the symbols' addresses are neither called nor read through.
        let found = names.iter().any(|name| unsafe { library.get::<*const ()>(name) }.is_ok());
        // Not closed: some drivers leave threads behind.
        std::mem::forget(library);
        if found { Ok(()) } else { Err("it is no Vulkan driver".into()) }
    }

    fn open(path: &Path) -> Result<Library, String> {
        // SAFETY: the libraries are those that the loader opens by itself, with what they do when they are opened.
        unsafe { Library::new(path) }.map_err(|e| e.to_string())
    }
}

#[cfg(not(all(feature = "gpu", unix, not(target_os = "macos"))))]
mod platform {
    use super::Path;

    pub fn loader() -> Result<(), String> {
        Ok(())
    }

    pub fn driver(_: &Path) -> Result<(), String> {
        Ok(())
    }
}
