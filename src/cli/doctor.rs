//! `echogrid doctor`.

use super::print_line;
use super::text::print_item;
use crate::Result;
use crate::geometry::layout;
use crate::kernels::{Backend, cpu::Cpu};
#[cfg(feature = "gpu")]
use crate::kernels::{adapter, adapters, vulkan::Drivers};
use crate::method::{self, REGISTRY, settings::Settings};
use crate::support::memory::{available, format_size};
use serde_json::json;

/// Arguments of `doctor`.
#[derive(Debug, clap::Args)]
pub struct DoctorArguments {
    /// Print the list as JSON
    #[arg(long)]
    json: bool,
}

impl DoctorArguments {
    /// Prints the processor, the free memory, the GPU adapters, and the methods.
    pub fn run(self) -> Result<u8> {
        let gpus = Gpus::find();
        let cpu = Cpu::new(0)?.adapter();
        let auto = gpus.hardware().unwrap_or("cpu");
        let methods = REGISTRY.iter().filter_map(|entry| {
            let method = method::make(Settings::of(entry.name)?);
            Some((entry.name, method::tile_words(method.as_ref()) * 4 / layout::TILE_CELLS))
        });
        if self.json {
            let methods: Vec<_> =
                methods.map(|(method, bytes)| json!({"method": method, "bytes_a_cell": bytes, "auto": auto})).collect();
            let (adapters, vulkan) = gpus.json();
            let list = json!({"version": env!("CARGO_PKG_VERSION"), "adapters": adapters, "vulkan": vulkan, "cpu": cpu, "memory_available": available(), "methods": methods});
            print_line!("{}", serde_json::to_string_pretty(&list).unwrap_or_default());
            return Ok(0);
        }
        print_line!("echogrid {}", env!("CARGO_PKG_VERSION"));
        print_item("cpu", &cpu);
        if let Some(free) = available() {
            print_item("memory", &format!("{} free", format_size(free)));
        }
        gpus.print();
        print_line!("");
        print_line!("method                    bytes a cell  --backend auto");
        for (name, bytes) in methods {
            print_line!("{name:<26}{bytes:<14}{auto}");
        }
        print_line!("himm with gro=true runs on the cpu only");
        Ok(0)
    }
}

/// The GPU adapters, and the Vulkan drivers that were searched for them.
#[cfg(feature = "gpu")]
struct Gpus {
    adapters: Vec<adapter::AdapterInfo>,
    drivers: Drivers,
}

#[cfg(feature = "gpu")]
impl Gpus {
    fn find() -> Gpus {
        Gpus { adapters: adapters(), drivers: Drivers::look() }
    }

    /// The name of the best hardware adapter.
    fn hardware(&self) -> Option<&str> {
        self.adapters.iter().find(|a| !a.software).map(|a| a.name.as_str())
    }

    /// The adapters and the drivers.
    fn json(&self) -> (serde_json::Value, serde_json::Value) {
        (json!(self.adapters), json!(self.drivers))
    }

    fn print(&self) {
        let Gpus { adapters, drivers } = self;
        for a in adapters {
            print_item("adapter", &a.to_string());
            print_item(
                "",
                &format!(
                    "largest buffer {}, of which a kernel binds {} at once; workgroups: {} along an axis, {} of memory each",
                    format_size(a.buffer),
                    format_size(a.binding),
                    a.workgroups,
                    format_size(a.workgroup_memory.into())
                ),
            );
        }
        if adapters.is_empty() {
            print_item("adapter", &format!("none: {}", drivers.why_none()));
        } else if self.hardware().is_none() {
            let name = &adapters[0].name;
            print_item("", &format!("no hardware adapter: --backend auto takes the CPU; --backend gpu takes {name}"));
        }
        if !adapters.is_empty() {
            drivers.broken().for_each(|manifest| print_item("broken", &manifest.to_string()));
        }
    }
}

/// Built without GPUs: there is nothing to list.
#[cfg(not(feature = "gpu"))]
struct Gpus;

#[cfg(not(feature = "gpu"))]
impl Gpus {
    fn find() -> Gpus {
        Gpus
    }

    fn hardware(&self) -> Option<&str> {
        None
    }

    fn json(&self) -> (serde_json::Value, serde_json::Value) {
        (json!([]), json!(null))
    }

    fn print(&self) {
        print_item("adapter", "none: this echogrid was built without the feature gpu");
    }
}
