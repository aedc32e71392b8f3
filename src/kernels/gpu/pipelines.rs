//! The pipelines of the methods' kernels, made when a batch first needs them.

use super::device::Device;
use super::options::Options;
use super::pipeline::{Description, Pipeline, patched};
use super::program::Program;
use super::recording::Recording;
use super::tile_binner::TileBinner;
use super::work::Work;
use crate::binning::snap::Footprint;
use crate::geometry::layout::{BROAD, Cone, NARROW_BEAM, WIDE};
use crate::kernels::bindings::bindings;
use crate::kernels::shader::{self, Kernel};
use crate::method::{self, Method, Unit};
use crate::{Error, Result};
use std::collections::BTreeMap;

/// What a batch's readings ask of a kernel; less is faster, on software adapters above all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Needs {
    /// One reaches farther than 1024 cells: membership takes 64 bits.
    wide: bool,
    /// One has a β of more than 22.5°: its off-axis angle is computed another way.
    broad: bool,
    /// One is narrow: it has a band beside its wedge.
    narrow: bool,
}

impl Needs {
    fn of(cones: &[Cone]) -> Needs {
        let flags = cones.iter().fold(0, |flags, c| flags | c.flags);
        Needs { wide: flags & WIDE != 0, broad: flags & BROAD != 0, narrow: flags & NARROW_BEAM != 0 }
    }
}

/// A pipeline of a method: its name, the kernel, what the readings need, the method's variant and declarations.
type Key = (&'static str, Kernel, Needs, bool, String);

fn key(method: &dyn Method, kernel: Kernel, needs: Needs) -> Key {
    (method::name(method), kernel, needs, method.variant().is_some_and(|v| v.1), method.declarations())
}

/// The WGSL overrides of a kernel, with their values.
fn overrides(method: &dyn Method, kernel: Kernel, needs: Needs, staged: bool) -> Vec<(&'static str, f64)> {
    let unit = method.unit();
    let mut values = Vec::new();
    if kernel != Kernel::Sum {
        values.extend(method.variant());
        if unit != Unit::Scan {
            values.extend([("BROAD_BEAMS", needs.broad), ("NARROW_BEAMS", needs.narrow)]);
        }
        if unit == Unit::Reading {
            // Only a cone in 32 bits has code of its own for tiles without an arc; a cone's axis has none.
            let specialize = staged && !needs.wide && method.footprint() != Footprint::Axis;
            values.push(("SPECIALIZE_TILES", specialize));
        }
    }
    if unit == Unit::Reading {
        values.push(("STAGED", staged));
    }
    values.into_iter().map(|(name, on)| (name, f64::from(on))).collect()
}

/// The pipelines so far.
pub struct Pipelines {
    methods: BTreeMap<Key, Pipeline>,
    binner: Option<TileBinner>,
    options: Options,
}

impl Pipelines {
    /// None yet.
    pub fn new(options: &Options) -> Pipelines {
        Pipelines { methods: BTreeMap::new(), binner: None, options: options.clone() }
    }

    /// The pipelines of the kernels that a recording runs; makes those that are not there yet.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] where the adapter refuses a kernel.
    pub fn prepare(&mut self, device: &Device, work: &Work, recording: &Recording) -> Result<Vec<(Program, Pipeline)>> {
        let needs = Needs::of(work.batch.cones());
        let mut prepared: Vec<(Program, Pipeline)> = Vec::new();
        for program in recording.programs() {
            if prepared.iter().all(|(known, _)| *known != program) {
                let pipeline = match program {
                    Program::Method(kernel) => self.of_method(device, work.method, kernel, needs)?,
                    Program::Binner(kernel) => self.binner(device)?.pipeline(kernel).clone(),
                };
                prepared.push((program, pipeline));
            }
        }
        Ok(prepared)
    }

    /// The kernels that bin cones into tiles.
    pub fn binner(&mut self, device: &Device) -> Result<&TileBinner> {
        match &mut self.binner {
            Some(binner) => Ok(binner),
            none => Ok(none.insert(TileBinner::new(device, &self.options.patches)?)),
        }
    }

    fn of_method(&mut self, device: &Device, method: &dyn Method, kernel: Kernel, needs: Needs) -> Result<Pipeline> {
        let key = key(method, kernel, needs);
        if let Some(pipeline) = self.methods.get(&key) {
            return Ok(pipeline.clone());
        }
        let label = format!("{} {}", key.0, kernel.name());
        let vec4s = self.vec4s_per_thread(device, method, needs);
        let source = patched(shader::source(method, kernel, needs.wide, vec4s)?, &self.options.patches);
        let scope = device.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let pipeline = Pipeline::new(
            device,
            &Description {
                label: &label,
                module: &device.module(&label, source),
                entry_point: kernel.name(),
                bindings: bindings(method.unit(), kernel)?,
                constants: &overrides(method, kernel, needs, self.options.stages(&device.info)),
            },
        );
        if let Some(e) = pollster::block_on(scope.pop()) {
            return Err(Error::NoAdapter(format!("{} refuses the kernel {label}: {e}", device.info)));
        }
        self.methods.insert(key, pipeline.clone());
        Ok(pipeline)
    }

    /// Vectors of four cells that a thread owns.
    fn vec4s_per_thread(&self, device: &Device, method: &dyn Method, needs: Needs) -> u32 {
        let suits = || match (device.info.software, needs.wide) {
            (false, _) => 1,
            // 64 bits take more registers.
            (true, true) => 2,
            (true, false) => method::entry_of(method).vec4s_per_thread,
        };
        self.options.vec4s_per_thread.unwrap_or_else(suits).clamp(1, 16).next_power_of_two()
    }
}
