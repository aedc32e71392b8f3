//! The parameters of the counting sensor models.

use crate::binning::scan::Selection;
use crate::grid::Palette;
use crate::log::classes::Classes;
use crate::sensor::{ParameterDoc, angle, length};
use crate::{Error, Result};
use std::f64::consts::{PI, TAU};

/// How a beam frees the cells along it (continuous models).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FreeRule {
    /// From the foot of the perpendicular on the beam, if it lies between the sensor and the hit (default).
    #[default]
    Projection,
    /// From samples at every `step` along the beam; each adds its own evidence.
    Sample,
    /// From the point of the beam between the sensor and `l` before the hit that is nearest to the foot.
    Clamp,
}

/// A counting sensor model (Doherty et al. 2019; Gan et al. 2020).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Csm {
    /// Whether evidence decreases with distance by the sparse kernel; otherwise it is counted.
    pub continuous: bool,
    /// Whether each class label has its own count; otherwise all hits are alike.
    pub semantic: bool,
    /// The class labels of a semantic model and their colours, "free" last.
    pub palette: Palette,
    /// Number of nearest poses that may update a cell; `None`: all.
    pub neighbours: Option<u16>,
    /// The rule by which a beam frees cells (continuous models).
    pub free: FreeRule,
    /// Distance between samples, metres (`free=sample`).
    pub step: f64,
    /// α of each class before the first reading.
    pub prior: f64,
    /// Depth of an obstacle, metres (discrete); `None`: two cells.
    pub w_obstacle: Option<f64>,
    /// Width of a beam, radians (discrete).
    pub w_beam: f64,
    /// Distance from which on readings are ignored and cells are not touched, metres.
    pub z_max: f64,
    /// Distance at which the kernel ends, metres (continuous models).
    pub l: f64,
    /// Value of the kernel at distance 0 (continuous models).
    pub sigma0: f64,
}

/// The largest `z_max`, metres. Up to this distance choices are exact in 53-bit integers of µm.
const FARTHEST: f64 = 90.0;

impl Csm {
    /// The defaults of one of the four models.
    pub fn of(continuous: bool, semantic: bool) -> Csm {
        Csm {
            continuous,
            semantic,
            palette: Classes::rooms().ok().filter(|_| semantic).map_or(Palette::plain(), |c| c.palette),
            neighbours: Some(16),
            free: FreeRule::Projection,
            step: 0.1,
            prior: 0.001,
            w_obstacle: None,
            w_beam: TAU / 133.0,
            z_max: 30.0,
            l: 0.2,
            sigma0: 0.1,
        }
    }

    /// Number of class labels of hits; 1 for a plain model.
    pub fn labels(&self) -> usize {
        if self.semantic { self.palette.classes() } else { 1 }
    }

    /// Half an obstacle's depth for cells of that size, µm.
    pub fn half_obstacle(&self, resolution: f64) -> i32 {
        (self.w_obstacle.unwrap_or(2.0 * resolution) * 5e5).round() as i32
    }

    /// The largest distance beyond a hit, or beside a beam, at which a cell of that size may be touched, µm.
    pub fn margin(&self, resolution: f64) -> i32 {
        if self.continuous { (self.l * 1e6).round() as i32 } else { self.half_obstacle(resolution) }
    }

    /// Which poses and beams may touch a cell of that size, metres.
    pub fn selection(&self, resolution: f64) -> Selection {
        Selection {
            neighbours: self.neighbours,
            z_max: self.z_max,
            margin: self.margin(resolution),
            beam_width: (!self.continuous).then_some(self.w_beam),
        }
    }

    /// The keys of `--set`.
    pub(super) fn keys(&self) -> &'static [ParameterDoc] {
        if self.continuous { CONTINUOUS } else { DISCRETE }
    }

    /// Sets one of its keys.
    pub(super) fn set(&mut self, key: &ParameterDoc, value: &str) -> Result<()> {
        let name = key.name;
        let wrong = |what: &str| Error::Usage(format!("`{name}={value}`: {name} takes {}{what}", key.values));
        let within = |parsed: std::result::Result<f64, String>, low: f64, high: f64| {
            parsed.ok().filter(|v| (low..=high).contains(v)).ok_or_else(|| wrong(""))
        };
        let number = |low: f64, high: f64| within(value.parse::<f64>().map_err(|e| e.to_string()), low, high);
        let metres = |low: f64, high: f64| within(length(value), low, high);
        match name {
            "neighbours" if value == "all" => self.neighbours = None,
            "neighbours" => {
                let count = value.parse().ok().filter(|n| (1..=64).contains(n));
                self.neighbours = Some(count.ok_or_else(|| wrong(""))?);
            }
            "free" => {
                let rules = [FreeRule::Projection, FreeRule::Sample, FreeRule::Clamp];
                let named = RULES.iter().position(|r| *r == value).ok_or_else(|| wrong(""))?;
                self.free = rules[named];
            }
            "step" => self.step = metres(0.001, 10.0)?,
            "prior" => self.prior = number(1e-6, 1e3)?,
            "w_obstacle" => self.w_obstacle = Some(metres(1e-6, 10.0)?),
            "w_beam" => self.w_beam = within(angle(value), 1e-6, PI * (1.0 - 1e-9))?,
            "z_max" => self.z_max = metres(0.001, FARTHEST)?,
            "l" => self.l = metres(0.001, 4.0)?,
            _ => self.sigma0 = number(1e-5, 1e3)?,
        }
        Ok(())
    }

    /// The values as text, in the order of the keys.
    pub(super) fn values(&self) -> Vec<String> {
        let neighbours = self.neighbours.map_or("all".into(), |n| n.to_string());
        let first = [neighbours, self.prior.to_string(), self.z_max.to_string()];
        let rest = match self.continuous {
            true => vec![
                RULES[self.free as usize].into(),
                self.step.to_string(),
                self.l.to_string(),
                self.sigma0.to_string(),
            ],
            false => {
                vec![self.w_obstacle.map_or("2 cells".into(), |w| w.to_string()), self.w_beam.to_string()]
            }
        };
        first.into_iter().chain(rest).collect()
    }
}

const RULES: [&str; 3] = ["projection", "sample", "clamp"];

const NEIGHBOURS: ParameterDoc =
    ParameterDoc::new("neighbours", "1..64|all", "16", "how many of the nearest poses speak of a cell");
const PRIOR: ParameterDoc =
    ParameterDoc::new("prior", "0.000001..1000", "0.001", "alpha of each class before the first reading");
const Z_MAX: ParameterDoc =
    ParameterDoc::new("z_max", "0.001..90 m", "30", "readings from here on say nothing, metres");

const DISCRETE: &[ParameterDoc] = &[
    NEIGHBOURS,
    PRIOR,
    Z_MAX,
    ParameterDoc::new("w_obstacle", "0.000001..10 m", "2 cells", "depth of an obstacle, metres"),
    ParameterDoc::new("w_beam", "0.000001..3.14 rad", "2.7deg", "width of a beam: 2π/133"),
];
const CONTINUOUS: &[ParameterDoc] = &[
    NEIGHBOURS,
    PRIOR,
    Z_MAX,
    ParameterDoc::new(
        "free",
        "projection|sample|clamp",
        "projection",
        "what of a beam frees: the nearest point, samples, or clamped",
    ),
    ParameterDoc::new("step", "0.001..10 m", "0.1", "from one sample to the next, metres (free=sample)"),
    ParameterDoc::new("l", "0.001..4 m", "0.2", "where the kernel ends, metres"),
    ParameterDoc::new("sigma0", "0.00001..1000", "0.1", "the kernel at distance 0"),
];
