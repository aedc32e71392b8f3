//! WGSL by plain concatenation: layout, cone, profile, method, driver; function names are the interface.

use crate::method::{self, Method, Pass};

const LAYOUT: &str = include_str!("../../../shaders/layout.wgsl");
const CONE: &str = include_str!("../../../shaders/cone.wgsl");
const WIDE: &str = include_str!("../../../shaders/wide.wgsl");
const NARROW: &str = include_str!("../../../shaders/narrow.wgsl");
const PROFILE: &str = include_str!("../../../shaders/profile.wgsl");
const FUSE: &str = include_str!("../../../shaders/driver/fuse.wgsl");
const WEIGH: &str = include_str!("../../../shaders/driver/weigh.wgsl");
const COUNT: &str = include_str!("../../../shaders/driver/count.wgsl");
const SUM: &str = include_str!("../../../shaders/driver/sum.wgsl");

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

/// The whole WGSL of a method's kernel; `wide`: for batches with readings that reach farther than 1024 cells.
pub fn source(method: &dyn Method, kernel: Kernel, wide: bool) -> String {
    let reach = if wide { WIDE } else { NARROW };
    let half = method::REGISTRY.iter().find(|e| e.name == method::name(method)).map_or("", |e| e.wgsl);
    match kernel {
        Kernel::Weigh => [LAYOUT, CONE, reach, PROFILE, half, WEIGH].join("\n"),
        Kernel::Count => [LAYOUT, CONE, reach, PROFILE, half, COUNT].join("\n"),
        Kernel::Fuse => [LAYOUT, CONE, reach, PROFILE, half, FUSE].join("\n"),
        Kernel::Sum => [LAYOUT, SUM].join("\n"),
    }
}
