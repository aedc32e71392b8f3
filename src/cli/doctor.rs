//! `echogrid doctor`.

use super::say;
use crate::kernels::gpu::adapter::{self, REMEDY};
use crate::kernels::{Backend, cpu::Cpu};
use crate::memory::{available, show};
use crate::method::{self, REGISTRY, settings::Settings};
use crate::{Result, layout};

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
            let list = serde_json::json!({"version": env!("CARGO_PKG_VERSION"), "adapters": adapters, "cpu": cpu, "memory_available": available(), "methods": methods});
            say!("{}", serde_json::to_string_pretty(&list).unwrap_or_default());
            return Ok(0);
        }
        say!("echogrid {}", env!("CARGO_PKG_VERSION"));
        say!("cpu       {cpu}");
        if let Some(free) = available() {
            say!("memory    {} free", show(free));
        }
        for a in &adapters {
            say!("adapter   {a}");
            say!(
                "          bindings up to {}, buffers up to {}, {} workgroups an axis, {} B of workgroup memory",
                show(a.binding),
                show(a.buffer),
                a.workgroups,
                a.workgroup_memory
            );
        }
        if adapters.is_empty() {
            say!("adapter   none: {REMEDY}");
        } else if hardware.is_none() {
            say!(
                "          no hardware adapter: --backend auto takes the CPU; --backend gpu takes {}",
                adapters[0].name
            );
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
