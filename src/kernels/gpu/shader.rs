//! WGSL by plain concatenation: layout, cone, profile, method, driver; function names are the interface.

use crate::method::{self, Method, Pass, Unit};

const LAYOUT: &str = include_str!("../../../shaders/geometry/layout.wgsl");
const CONE: &str = include_str!("../../../shaders/geometry/cone.wgsl");
const INT64: &str = include_str!("../../../shaders/geometry/int64.wgsl");
const WIDE: &str = include_str!("../../../shaders/geometry/cone/wide.wgsl");
const NARROW: &str = include_str!("../../../shaders/geometry/cone/narrow.wgsl");
const PROFILE: &str = include_str!("../../../shaders/geometry/profile.wgsl");
const READINGS: &str = include_str!("../../../shaders/method/driver/readings.wgsl");
const SCANS: &str = include_str!("../../../shaders/method/driver/scans.wgsl");
const ORDER: &str = include_str!("../../../shaders/binning/scan/order.wgsl");
const SCAN: &str = include_str!("../../../shaders/method/driver/scan.wgsl");
const UPDATES: &str = include_str!("../../../shaders/method/driver/updates.wgsl");
const REGION: &str = include_str!("../../../shaders/binning/update/region.wgsl");
const UPDATE: &str = include_str!("../../../shaders/method/driver/update.wgsl");
const TILE: &str = include_str!("../../../shaders/method/driver/tile.wgsl");
const STAGE: &str = include_str!("../../../shaders/method/driver/stage.wgsl");
const FUSE: &str = include_str!("../../../shaders/method/driver/fuse.wgsl");
const WEIGH: &str = include_str!("../../../shaders/method/driver/weigh.wgsl");
const COUNT: &str = include_str!("../../../shaders/method/driver/count.wgsl");
const SUM: &str = include_str!("../../../shaders/method/driver/sum.wgsl");

/// A kernel of a method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kernel {
    /// Weigh.
    Weigh,
    /// Count.
    Count,
    /// Fuse.
    Fuse,
    /// The sum of each reading's parts.
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
    /// Its entry point, and label.
    pub fn name(self) -> &'static str {
        match self {
            Kernel::Weigh => "weigh",
            Kernel::Count => "count",
            Kernel::Fuse => "fuse",
            Kernel::Sum => "sum",
        }
    }
}

/// The whole WGSL of a method's kernel; `wide`: for batches with readings that reach farther than 1024 cells; `groups`: how
/// many times four cells a thread owns, 1 to 16 and a power of two.
pub fn source(method: &dyn Method, kernel: Kernel, wide: bool, groups: u32) -> String {
    let half = method::REGISTRY.iter().find(|e| e.name == method::name(method)).map_or("", |e| e.wgsl);
    if method.unit() == Unit::Scan {
        return [LAYOUT, SCANS, INT64, ORDER, &method.declarations(), half, SCAN].join("\n");
    }
    let threads = format!("const THREADS: u32 = {}u;", 64 / groups);
    if method.unit() == Unit::Update {
        // No update reaches far.
        let each = each(UPDATE, groups);
        return [LAYOUT, UPDATES, CONE, NARROW, PROFILE, REGION, half, &threads, TILE, &each].join("\n");
    }
    let reach = if wide { [INT64, WIDE].join("\n") } else { NARROW.into() };
    let driver = match kernel {
        Kernel::Weigh => WEIGH,
        Kernel::Count => COUNT,
        Kernel::Fuse => FUSE,
        Kernel::Sum => return [LAYOUT, READINGS, SUM].join("\n"),
    };
    [LAYOUT, READINGS, CONE, &reach, PROFILE, half, &threads, TILE, STAGE, &each(driver, groups)].join("\n")
}

/// Writes the lines between `// each GROUP` and `// end` once for each group: loops over arrays that a thread owns end up
/// in memory where a compiler doesn't unroll them.
pub(super) fn each(driver: &str, groups: u32) -> String {
    let (mut text, mut block) = (String::new(), None::<Vec<&str>>);
    for line in driver.split_inclusive('\n') {
        match (line.trim(), &mut block) {
            ("// each GROUP", _) => block = Some(Vec::new()),
            ("// end", Some(lines)) => {
                for group in 0..groups {
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
