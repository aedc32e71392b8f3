//! `echogrid doctor`.

use super::common::item;
use super::say;
use crate::Result;
use crate::geometry::layout;
use crate::kernels::vulkan::Drivers;
use crate::kernels::{Backend, adapter, cpu::Cpu};
use crate::method::{self, REGISTRY, settings::Settings};
use crate::support::memory::{available, show};

/// Arguments of `doctor`.
#[derive(Debug, clap::Args)]
pub struct Doctor {
    /// Print the list as JSON
    #[arg(long)]
    json: bool,
}

impl Doctor {
    /// Lists what there is.
    pub fn run(self) -> Result<u8> {
        let adapters = adapter::list();
        let drivers = Drivers::look();
        let cpu = Cpu::new(0)?.adapter();
        let hardware = adapters.iter().find(|a| !a.software);
        let auto = hardware.map_or("cpu", |a| a.name.as_str());
        let methods = REGISTRY.iter().filter_map(|entry| {
            let method = method::make(Settings::of(entry.name)?);
            Some((entry.name, method::tile_words(method.as_ref()) * 4 / layout::TILE_CELLS))
        });
        if self.json {
            let methods: Vec<_> = methods
                .map(|(method, bytes)| serde_json::json!({"method": method, "bytes_a_cell": bytes, "auto": auto}))
                .collect();
            let list = serde_json::json!({"version": env!("CARGO_PKG_VERSION"), "adapters": adapters, "vulkan": drivers, "cpu": cpu, "memory_available": available(), "methods": methods});
            say!("{}", serde_json::to_string_pretty(&list).unwrap_or_default());
            return Ok(0);
        }
        say!("echogrid {}", env!("CARGO_PKG_VERSION"));
        item("cpu", &cpu);
        if let Some(free) = available() {
            item("memory", &format!("{} free", show(free)));
        }
        for a in &adapters {
            item("adapter", &a.to_string());
            item(
                "",
                &format!(
                    "largest buffer {}, of which a kernel binds {} at once; workgroups: {} along an axis, {} of memory each",
                    show(a.buffer),
                    show(a.binding),
                    a.workgroups,
                    show(a.workgroup_memory.into())
                ),
            );
        }
        if adapters.is_empty() {
            item("adapter", &format!("none: {}", drivers.why_none()));
        } else if hardware.is_none() {
            let name = &adapters[0].name;
            item("", &format!("no hardware adapter: --backend auto takes the CPU; --backend gpu takes {name}"));
        }
        if !adapters.is_empty() {
            drivers.broken().for_each(|manifest| item("broken", &manifest.to_string()));
        }
        say!("");
        say!("method                    bytes a cell  --backend auto");
        for (name, bytes) in methods {
            say!("{name:<26}{bytes:<14}{auto}");
        }
        say!("himm with gro=true runs on the cpu only");
        Ok(0)
    }
}
