//! The WGSL of a method's kernels, composed by plain concatenation: layout, bindings, cone, profile, method, driver. Function names are
//! the interface between the parts.

use super::KernelError;
use crate::method::{self, Method, Pass, Unit};

const LAYOUT: &str = include_str!("../../shaders/geometry/layout.wgsl");
const CONE: &str = include_str!("../../shaders/geometry/cone.wgsl");
const INT64: &str = include_str!("../../shaders/geometry/int64.wgsl");
const WIDE: &str = include_str!("../../shaders/geometry/cone/wide.wgsl");
const NARROW: &str = include_str!("../../shaders/geometry/cone/narrow.wgsl");
const PROFILE: &str = include_str!("../../shaders/geometry/profile.wgsl");
const READINGS: &str = include_str!("../../shaders/method/driver/readings.wgsl");
const SCANS: &str = include_str!("../../shaders/method/driver/scans.wgsl");
const ORDER: &str = include_str!("../../shaders/binning/scan/order.wgsl");
const SCAN: &str = include_str!("../../shaders/method/driver/scan.wgsl");
const UPDATES: &str = include_str!("../../shaders/method/driver/updates.wgsl");
const REGION: &str = include_str!("../../shaders/binning/update/region.wgsl");
const REACH: &str = include_str!("../../shaders/binning/update/reach.wgsl");
const UPDATE: &str = include_str!("../../shaders/method/driver/update.wgsl");
const TILE: &str = include_str!("../../shaders/method/driver/tile.wgsl");
const STAGE: &str = include_str!("../../shaders/method/driver/stage.wgsl");
const FUSE: &str = include_str!("../../shaders/method/driver/fuse.wgsl");
const WEIGH: &str = include_str!("../../shaders/method/driver/weigh.wgsl");
const COUNT: &str = include_str!("../../shaders/method/driver/count.wgsl");
const SUM: &str = include_str!("../../shaders/method/driver/sum.wgsl");

/// A kernel of a method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kernel {
    /// Each tile's part of each reading's evidence ([`Pass::Weigh`]).
    Weigh,
    /// The arc cells of each reading ([`Pass::Count`]).
    Count,
    /// The update of the cells ([`Pass::Fuse`]).
    Fuse,
    /// The sum of each reading's parts ([`method::Step::Sum`]).
    Sum,
}

impl From<Pass> for Kernel {
    fn from(pass: Pass) -> Kernel {
        match pass {
            Pass::Weigh => Kernel::Weigh,
            Pass::Count => Kernel::Count,
            Pass::Fuse => Kernel::Fuse,
        }
    }
}

impl Kernel {
    /// The entry point's name, also the label of passes and pipelines.
    pub fn name(self) -> &'static str {
        match self {
            Kernel::Weigh => "weigh",
            Kernel::Count => "count",
            Kernel::Fuse => "fuse",
            Kernel::Sum => "sum",
        }
    }
}

/// Bytes of one tile's part of a reading's sum: one number where kernels stage readings in workgroup memory, else one for each vector
/// of four cells.
pub const fn part_bytes(staged: bool) -> usize {
    if staged { size_of::<f32>() } else { 64 * size_of::<f32>() }
}

/// The whole WGSL of a method's kernel. `wide`: for batches with readings that reach farther than 1024 cells. `vec4s_per_thread`: vectors
/// of four cells that a thread owns, 1 to 16 and a power of two.
///
/// # Errors
/// [`KernelError::NoKernel`] where the method's kind of input has no such kernel.
pub fn source(method: &dyn Method, kernel: Kernel, wide: bool, vec4s_per_thread: u32) -> Result<String, KernelError> {
    let half = method::entry_of(method).wgsl;
    let threads = format!("const THREADS: u32 = {}u;", 64 / vec4s_per_thread);
    let driver = match (method.unit(), kernel) {
        (Unit::Reading, Kernel::Weigh) => WEIGH,
        (Unit::Reading, Kernel::Count) => COUNT,
        (Unit::Reading, Kernel::Fuse) => FUSE,
        (Unit::Reading, Kernel::Sum) => return Ok([LAYOUT, SUM].join("\n")),
        (Unit::Scan, Kernel::Fuse) => {
            return Ok([LAYOUT, SCANS, INT64, ORDER, &method.declarations(), half, SCAN].join("\n"));
        }
        (Unit::Update, Kernel::Fuse) => {
            // No update reaches farther than 512 cells.
            let driver = unroll(UPDATE, vec4s_per_thread);
            return Ok(
                [LAYOUT, UPDATES, CONE, NARROW, PROFILE, REGION, half, &threads, TILE, REACH, &driver].join("\n")
            );
        }
        (input @ (Unit::Scan | Unit::Update), Kernel::Weigh | Kernel::Count | Kernel::Sum) => {
            return Err(KernelError::NoKernel { kernel: kernel.name(), input: input.name() });
        }
    };
    let reach = if wide { [INT64, WIDE].join("\n") } else { NARROW.into() };
    let driver = unroll(driver, vec4s_per_thread);
    Ok([LAYOUT, READINGS, CONE, &reach, PROFILE, half, &threads, TILE, STAGE, &driver].join("\n"))
}

/// Repeats the lines between `// each GROUP` and `// end` `count` times, `GROUP` replaced by the number: a compiler that does not
/// unroll a loop over an array that a thread owns keeps the array in memory.
pub(super) fn unroll(driver: &str, count: u32) -> String {
    let (mut text, mut block) = (String::new(), None::<Vec<&str>>);
    for line in driver.split_inclusive('\n') {
        match (line.trim(), &mut block) {
            ("// each GROUP", _) => block = Some(Vec::new()),
            ("// end", Some(lines)) => {
                for group in 0..count {
                    lines.iter().for_each(|line| text += &line.replace("GROUP", &group.to_string()));
                }
                block = None;
            }
            (_, Some(lines)) => lines.push(line),
            (_, None) => text += line,
        }
    }
    text
}
