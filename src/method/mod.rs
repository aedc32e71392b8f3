//! The methods: how a cell's state changes with a reading.
//!
//! A method is a file here and its twin under `shaders/method/`, connected by an entry of [`REGISTRY`]. The file has the pure
//! functions and the cell's state; the drivers have the loops over tiles, readings and rows (`kernels`). A cell's state is a
//! few 32-bit words, one in each *plane*. The first two planes of every method count its interior and arc updates.

pub mod bayes;
pub mod certainty;
pub mod csm;
pub mod dempster_shafer;
pub mod driver;
pub mod features;
pub mod himm;
pub mod input;

pub mod odds;
pub mod settings;
pub mod truth;

use crate::binning::snap::{Footprint, Snapped};
use crate::geometry::layout;
use crate::grid::{Class, Scale};
use crate::log::reading::Outcome;
use crate::sensor::{Overrides, Sensor};
use crate::support::suggest::closest;
use crate::{Error, Result};
pub use driver::Pass;
use driver::{Job, WrongInput};
pub use input::{Completed, Evidence, Input, LogFacts, RequiredSensor, Spread, Unit};
use settings::Settings;

/// One step of a sweep over a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// A kernel over every chunk, with the frame's mode bits.
    Pass(Pass, u32),
    /// Each reading's parts, added in tile order to what its share holds.
    Sum,
    /// Makes each reading's share from its count, on the host ([`Method::share`]).
    NormalizeByCount,
    /// Copies the shares to the host (out of core).
    ReadBack,
    /// Adds each reading's count to its share, on the host (out of core).
    AccumulateCounts,
}

/// The rounds of the out-of-core pipeline over the chunks. In each a chunk's readings are traversed once or more, with these steps
/// over each of their batches. The state after the last round is the map.
pub type Rounds = &'static [&'static [Steps]];

/// Steps over a batch, in order.
pub type Steps = &'static [Step];

/// A layer that a method makes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayerSpec {
    /// Name of the layer in files and reports.
    pub name: &'static str,
    /// Description, with the unit.
    pub about: &'static str,
    /// The value of a cell that no reading reached.
    pub fill: f32,
    /// Colour scale.
    pub scale: Scale,
    /// Whether its values are whole numbers, stored as u32.
    pub integer: bool,
}

/// A method with its parameters set.
pub trait Method: Send + Sync {
    /// The parameters.
    fn settings(&self) -> Settings;

    /// A reading's own evidence of a cell, for explanations.
    fn evidence(&self) -> Evidence;

    /// Number of planes after the two counts. Every word of a cell is 0 before the first reading.
    fn planes(&self) -> usize;

    /// The method's input for cells of `resolution`, metres.
    fn input(&self, _resolution: f64) -> Input {
        Input::Readings
    }

    /// The kind of the method's input, which does not depend on the size of the cells.
    fn unit(&self) -> Unit {
        self.input(1.0).unit()
    }

    /// The one kind of sensor whose readings it maps; `None`: any.
    fn required_sensor(&self) -> Option<RequiredSensor> {
        None
    }

    /// Narrows a sensor's limits to what the method trusts; limits that the user set stay as they are.
    fn limit_sensor(&self, _sensor: &mut Sensor, _set: &Overrides) {}

    /// How far around a beam the method updates cells, beyond the beam's cone.
    fn spread(&self) -> Spread {
        Spread::default()
    }

    /// The method's parameters, completed from a log and a grid.
    ///
    /// # Errors
    /// [`Error::Usage`] for a grid that the method can't map, [`Error::Input`] for a log that lacks what it needs.
    fn complete(&self, _log: &LogFacts) -> Result<Completed> {
        Ok(Completed { settings: self.settings(), classes: None })
    }

    /// Index of the plane, counted after the two counts, that sums marks of the beams or updates that a cell took. With it `verify`
    /// can tell whether two backends took the same. `None` for methods whose counts suffice.
    fn marks(&self) -> Option<usize> {
        None
    }

    /// The method's lengths in the frame for cells of that size, µm.
    fn limits(&self, _resolution: f64) -> [i32; 4] {
        [0; 4]
    }

    /// WGSL constants that these parameters decide.
    fn declarations(&self) -> String {
        String::new()
    }

    /// The cells that a reading may update.
    fn footprint(&self) -> Footprint {
        Footprint::Cone
    }

    /// The steps over each batch, in order, for each sweep over the log.
    fn sweeps(&self) -> &'static [&'static [Step]];

    /// The rounds of the out-of-core pipeline; `None`: a cell needs its neighbours in other chunks, so that the chunks must be
    /// resident together.
    fn rounds(&self) -> Option<Rounds> {
        Some(&[&[&[Step::Pass(Pass::Fuse, layout::COUNT)]]])
    }

    /// The method's constants in the frame.
    fn constants(&self) -> [[f32; 4]; 2] {
        [[0.0; 4]; 2]
    }

    /// The override of the WGSL half that these parameters decide, if it has one: two kernels instead of a branch.
    fn variant(&self) -> Option<(&'static str, bool)> {
        None
    }

    /// The four parameters of the profile for one reading.
    fn profile(&self, _sensor: &Sensor, _snapped: &Snapped) -> [f32; 4] {
        [0.0; 4]
    }

    /// The share of a reading, made from its count of arc cells ([`Step::NormalizeByCount`]).
    fn share(&self, _count: u32, _outcome: Outcome) -> [u32; 4] {
        [0; 4]
    }

    /// The layers, in the order of [`Method::values`].
    fn layers(&self) -> Vec<LayerSpec>;

    /// Whether a cell without counted updates holds evidence all the same, from increments too small to count as updates.
    fn has_subthreshold_evidence(&self, _words: &[u32]) -> bool {
        false
    }

    /// Adds the increments of a cell's α to the map's sums, if the method has α.
    fn gains(&self, _words: &[u32], _sums: &mut Vec<f64>) {}

    /// A cell's layers and class from its words, one of each plane, the two counts first.
    fn values(&self, words: &[u32], layers: &mut [f32]) -> Class;

    /// The value of a touched cell in the combined picture, from −1 (surely empty) to 1 (surely occupied), from its layers.
    fn combined(&self, layers: &[f32], class: Class) -> f32;

    /// Runs one pass over one tile on the CPU.
    ///
    /// # Errors
    /// [`WrongInput`] if the job's input is not of the kind that the method takes.
    fn run(&self, pass: Pass, job: &Job, state: &mut [u32]) -> std::result::Result<(), WrongInput>;

    /// The reason why only the CPU can run the method with these parameters, if there is one.
    fn cpu_only(&self) -> Option<&'static str> {
        None
    }
}

/// Operations of one cell update with the default parameters, membership included, counted in the source of all passes:
/// f32 + − × ÷ √ one each, 32-bit integer + − × and comparisons one each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cost {
    /// Floating-point operations.
    pub flop: u32,
    /// Integer operations.
    pub int: u32,
}

/// An entry of the registry. It connects a method's two halves and has the texts for help, README and tests.
pub struct Entry {
    /// Name of the method on the command line.
    pub name: &'static str,
    /// Author and year of the method's description.
    pub source: &'static str,
    /// One line about the state of a cell and how its class is decided.
    pub about: &'static str,
    /// The WGSL source of the method's GPU half.
    pub wgsl: &'static str,
    /// Operations of an update.
    pub cost: Cost,
    /// Vectors of four cells that a GPU's thread owns on a software adapter, a power of two up to 16: the fastest, measured
    /// (`benches/NOTES.md`). A hardware adapter's thread owns one, which fills the card best.
    pub vec4s_per_thread: u32,
    /// Makes the method from its parameters, which must be of this method.
    pub make: fn(Settings) -> Option<Box<dyn Method>>,
}

/// All methods.
pub const REGISTRY: &[Entry] = &[
    certainty::ENTRY,
    dempster_shafer::ENTRY,
    bayes::ENTRY,
    himm::ENTRY,
    truth::ENTRY,
    csm::DISCRETE,
    csm::CONTINUOUS,
    csm::SEMANTIC_DISCRETE,
    csm::SEMANTIC_CONTINUOUS,
    features::ENTRY,
];

/// The registry entry with this name; the error suggests the nearest name.
pub fn entry(name: &str) -> Result<&'static Entry> {
    REGISTRY.iter().find(|e| e.name == name).ok_or_else(|| {
        let names: Vec<&str> = REGISTRY.iter().map(|e| e.name).collect();
        Error::Usage(format!("there is no method \"{name}\"{}", nearest(name, &names)))
    })
}

/// The method with these parameters.
pub fn make(settings: Settings) -> Box<dyn Method> {
    match REGISTRY.iter().find_map(|e| (e.make)(settings)) {
        Some(method) => method,
        None => unreachable!("every variant of Settings has its line in the registry"),
    }
}

/// `; did you mean "x"? There are a, b, c.`
pub fn nearest(name: &str, known: &[&str]) -> String {
    let hint = closest(name, known).map(|name| format!("did you mean {name}? ")).unwrap_or_default();
    format!("; {hint}there are {}", known.join(", "))
}

/// Number of words of a cell, including the two counts.
pub fn planes(method: &dyn Method) -> usize {
    2 + method.planes()
}

/// Number of words of a tile.
pub fn tile_words(method: &dyn Method) -> usize {
    planes(method) * layout::TILE_CELLS
}

/// The registry entry of a method.
pub fn entry_of(method: &dyn Method) -> &'static Entry {
    match REGISTRY.iter().find(|e| (e.make)(method.settings()).is_some()) {
        Some(entry) => entry,
        None => unreachable!("every variant of Settings has its line in the registry"),
    }
}

/// Number of vectors of four cells that a thread owns on a software adapter.
pub fn vec4s_per_thread(method: &dyn Method) -> usize {
    entry_of(method).vec4s_per_thread as usize
}

/// The method's name in the registry.
pub fn name(method: &dyn Method) -> &'static str {
    entry_of(method).name
}

/// Adds numbers to sums, element by element.
pub(crate) fn add(numbers: &[f64], sums: &mut Vec<f64>) {
    sums.resize(numbers.len().max(sums.len()), 0.0);
    sums.iter_mut().zip(numbers).for_each(|(sum, n)| *sum += n);
}
