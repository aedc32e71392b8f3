//! Which backend a run takes, and why.

use super::adapter::AdapterInfo;
use super::vulkan::Drivers;
use super::{Backend, cpu::Cpu};
use crate::method::Method;
use crate::{Error, Result};

/// Why there is no GPU backend.
const NO_GPU: &str = "this echogrid is built without its feature gpu";

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

/// Opens the backend. `threads` are those of the CPU backend, 0: one for each core.
///
/// # Errors
/// [`Error::NoAdapter`] where an adapter is demanded and none will do.
pub fn choose(choice: Choice, method: &dyn Method, threads: usize) -> Result<Chosen> {
    let cpu = |why: String| -> Result<Chosen> { Ok(Chosen { backend: Box::new(Cpu::new(threads)?), why }) };
    match (choice, method.cpu_only()) {
        (Choice::Cpu, _) => cpu(String::new()),
        (Choice::Gpu, Some(why)) => Err(Error::NoAdapter(format!("{why}: use `backend cpu`"))),
        (Choice::Auto, Some(why)) => cpu(why.into()),
        (Choice::Gpu, None) => Ok(Chosen { backend: open_gpu(false)?, why: String::new() }),
        (Choice::Auto, None) => match open_gpu(true) {
            Ok(backend) => Ok(Chosen { backend, why: "the best hardware adapter".into() }),
            Err(_) if cfg!(not(feature = "gpu")) => cpu(NO_GPU.into()),
            Err(_) => {
                let software = adapters().first().map(|a| format!(", only {}", a.name)).unwrap_or_default();
                let broken = Drivers::look().broken().next().map(|m| format!(" ({m})")).unwrap_or_default();
                cpu(format!("there is no hardware GPU adapter{software}{broken}"))
            }
        },
    }
}

/// Opens the GPU backend; with `hardware` a software adapter is refused.
#[cfg(feature = "gpu")]
fn open_gpu(hardware: bool) -> Result<Box<dyn Backend>> {
    use super::gpu::{Gpu, Options};
    Ok(Box::new(Gpu::new(&Options { hardware, ..Options::default() })?))
}

/// The same of a program that has no GPU backend.
#[cfg(not(feature = "gpu"))]
fn open_gpu(_hardware: bool) -> Result<Box<dyn Backend>> {
    Err(Error::NoAdapter(format!("{NO_GPU}: use `backend cpu`")))
}

/// Every adapter that can compute, the best first; none where the program is built without the `gpu` feature.
pub fn adapters() -> Vec<AdapterInfo> {
    #[cfg(feature = "gpu")]
    return super::gpu::adapter::list();
    #[cfg(not(feature = "gpu"))]
    Vec::new()
}
