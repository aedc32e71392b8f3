//! Which backend a run takes, and why.

use super::gpu::vulkan::Drivers;
use super::gpu::{self, Gpu, adapter};
use super::{Backend, cpu::Cpu};
use crate::method::Method;
use crate::{Error, Result};

/// What the user asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Choice {
    /// The best hardware adapter, else the CPU.
    #[default]
    Auto,
    /// An adapter; a software one counts.
    Gpu,
    /// The CPU's kernels.
    Cpu,
}

/// A backend and why it was taken.
pub struct Chosen {
    /// The backend.
    pub backend: Box<dyn Backend>,
    /// Why, in a sentence without its full stop; empty where the user chose.
    pub why: String,
}

/// Whether `ECHOGRID_REQUIRE_GPU=1` makes a missing adapter an error wherever the gpu is asked for.
pub fn gpu_required() -> bool {
    std::env::var_os("ECHOGRID_REQUIRE_GPU").is_some_and(|v| v == "1")
}

/// Opens the backend; `threads` are the CPU's, 0: one a core.
///
/// # Errors
/// [`Error::NoAdapter`] where an adapter is demanded and none will do.
pub fn choose(choice: Choice, method: &dyn Method, threads: usize) -> Result<Chosen> {
    let cpu = |why: String| -> Result<Chosen> { Ok(Chosen { backend: Box::new(Cpu::new(threads)?), why }) };
    let open = |hardware: bool| Gpu::new(&gpu::Options { hardware, ..Default::default() });
    match (choice, method.cpu_only()) {
        (Choice::Cpu, _) => cpu(String::new()),
        (Choice::Gpu, Some(why)) => Err(Error::NoAdapter(format!("{why}: use --backend cpu"))),
        (Choice::Auto, Some(why)) => cpu(why.into()),
        (Choice::Gpu, None) => Ok(Chosen { backend: Box::new(open(false)?), why: String::new() }),
        (Choice::Auto, None) => match open(true) {
            Ok(gpu) => Ok(Chosen { backend: Box::new(gpu), why: "the best hardware adapter".into() }),
            Err(_) => {
                let software = adapter::list().first().map(|a| format!(", only {}", a.name)).unwrap_or_default();
                let broken = Drivers::look().broken().next().map(|m| format!(" ({m})")).unwrap_or_default();
                cpu(format!("there is no hardware GPU adapter{software}{broken}"))
            }
        },
    }
}
