//! The parameters of every method, with their defaults; `--set key=value` changes them.

mod csm;
mod features;

pub use csm::{Csm, FreeRule};
pub use features::Features;

use crate::sensor::ParameterDoc;
use crate::{Error, Result};

/// Order of a certainty grid's updates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Order {
    /// Each reading frees, then occupies, before the next (default).
    #[default]
    Sequential,
    /// Every reading of the log frees first, then every one occupies (Moravec & Elfes 1985).
    Batch,
}

/// Certainty grid.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Certainty {
    /// Order of the updates.
    pub order: Order,
}

/// Dempster-Shafer: mass of "empty" in the interior of a cone.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Rho {
    /// 1/n, n = the reading's arc cells (default).
    #[default]
    OneOverN,
    /// A constant, 0 to 1.
    Constant(f64),
}

/// Dempster-Shafer: a reading's masses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MassModel {
    /// 1/n on the arc, ρ in the interior (Pagac et al. 1998).
    #[default]
    Pagac,
    /// Murphy's expressions 11.1 and 11.2, without floors.
    Murphy,
}

/// Dempster-Shafer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DempsterShafer {
    /// Mass of "empty" in the interior (model pagac).
    pub rho: Rho,
    /// A reading's masses.
    pub model: MassModel,
    /// The largest mass that one reading may give, below 1.
    pub cap: f64,
    /// Murphy's Max_occ (model murphy).
    pub max_occ: f64,
}

impl Default for DempsterShafer {
    fn default() -> Self {
        DempsterShafer { rho: Rho::OneOverN, model: MassModel::Pagac, cap: 0.98, max_occ: 0.98 }
    }
}

/// Bayes: a reading's likelihoods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Likelihood {
    /// Murphy 2000, expressions 11.1 and 11.2 (default).
    #[default]
    Murphy,
    /// `p_hit` on the arc, `p_miss` in the interior: for lasers.
    Constant,
}

/// Bayes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bayes {
    /// A reading's likelihoods; `None`: by sensor, Murphy's for sonars and constant for lasers (a [`Session`](crate::pipeline::session::Session)
    /// looks at the log's; without one it is Murphy's).
    pub model: Option<Likelihood>,
    /// Murphy's Max_occ: P(s|occupied) is at most this.
    pub max_occ: f64,
    /// P(s|occupied) on the arc is at least this (0: the book's literal formula).
    pub region_one_floor: f64,
    /// P(s|empty) in the interior is at least this (0: the book's literal formula).
    pub region_two_floor: f64,
    /// P(s|occupied) on the arc, model constant.
    pub p_hit: f64,
    /// P(s|occupied) in the interior, model constant.
    pub p_miss: f64,
    /// A cell is occupied above this probability.
    pub p_occupied: f64,
    /// A cell is empty below this probability.
    pub p_empty: f64,
}

impl Default for Bayes {
    fn default() -> Self {
        Bayes {
            model: None,
            max_occ: 0.98,
            region_one_floor: 0.5,
            region_two_floor: 0.5,
            p_hit: 0.7,
            p_miss: 0.4,
            p_occupied: 0.6,
            p_empty: 0.4,
        }
    }
}

impl Bayes {
    /// The likelihoods in use.
    pub fn likelihood(&self) -> Likelihood {
        self.model.unwrap_or_default()
    }
}

/// HIMM, the histogrammic in-motion mapping.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Himm {
    /// Growth-rate operator: an occupied cell takes weight from its neighbours.
    pub gro: bool,
}

/// A method and its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Settings {
    /// Moravec-Elfes certainty grid.
    Certainty(Certainty),
    /// Dempster-Shafer evidential grid.
    DempsterShafer(DempsterShafer),
    /// Bayesian occupancy grid.
    Bayes(Bayes),
    /// Histogrammic in-motion mapping.
    Himm(Himm),
    /// The laser truth: hits and passes of the nearest beam of each scan.
    Truth,
    /// A counting sensor model.
    Csm(Csm),
    /// Feature-based occupancy grid.
    Features(Features),
}

const CERTAINTY: &[ParameterDoc] = &[ParameterDoc::new(
    "order",
    "sequential|batch",
    "sequential",
    "each reading frees then occupies, or every one frees first",
)];
const DEMPSTER_SHAFER: &[ParameterDoc] = &[
    ParameterDoc::new("rho", "1/n|0..1", "1/n", "mass of empty in the interior of a cone"),
    ParameterDoc::new("model", "pagac|murphy", "pagac", "a reading's masses: 1/n and rho, or Murphy's 11.1 and 11.2"),
    ParameterDoc::new("cap", "0..0.999999", "0.98", "largest mass that one reading may give"),
    ParameterDoc::new("max_occ", "0..1", "0.98", "Murphy's Max_occ (model murphy)"),
];
const BAYES: &[ParameterDoc] = &[
    ParameterDoc::new(
        "model",
        "murphy|constant",
        "murphy, for lasers constant",
        "a reading's likelihoods: Murphy's profile, or two constants for lasers",
    ),
    ParameterDoc::new("max_occ", "0..1", "0.98", "largest P(s|occupied) on the arc"),
    ParameterDoc::new(
        "region_one_floor",
        "0..0.98",
        "0.5",
        "smallest P(s|occupied) on the arc; 0: the book's literal formula",
    ),
    ParameterDoc::new(
        "region_two_floor",
        "0..0.98",
        "0.5",
        "smallest P(s|empty) in the interior; 0: the book's literal formula",
    ),
    ParameterDoc::new("p_hit", "0.02..0.98", "0.7", "P(s|occupied) on the arc, model constant"),
    ParameterDoc::new("p_miss", "0.02..0.98", "0.4", "P(s|occupied) in the interior, model constant"),
    ParameterDoc::new("p_occupied", "0.5..1", "0.6", "a cell is occupied above this probability"),
    ParameterDoc::new("p_empty", "0..0.5", "0.4", "a cell is empty below this probability"),
];
const HIMM: &[ParameterDoc] = &[ParameterDoc::new(
    "gro",
    "true|false",
    "false",
    "growth-rate operator: an occupied cell takes from its neighbours",
)];

impl Settings {
    /// The default parameters of a method, by its name in the registry; `None` if there is no such method.
    pub fn of(method: &str) -> Option<Settings> {
        Some(match method {
            "certainty" => Settings::Certainty(Certainty::default()),
            "dempster-shafer" => Settings::DempsterShafer(DempsterShafer::default()),
            "bayes" => Settings::Bayes(Bayes::default()),
            "himm" => Settings::Himm(Himm::default()),
            "truth" => Settings::Truth,
            "csm-discrete" => Settings::Csm(Csm::of(false, false)),
            "csm-continuous" => Settings::Csm(Csm::of(true, false)),
            "csm-semantic-discrete" => Settings::Csm(Csm::of(false, true)),
            "csm-semantic-continuous" => Settings::Csm(Csm::of(true, true)),
            "features" => Settings::Features(Features::default()),
            _ => return None,
        })
    }

    /// The keys this method takes.
    pub fn keys(&self) -> &'static [ParameterDoc] {
        match self {
            Settings::Certainty(_) => CERTAINTY,
            Settings::DempsterShafer(_) => DEMPSTER_SHAFER,
            Settings::Bayes(_) => BAYES,
            Settings::Himm(_) => HIMM,
            Settings::Truth => &[],
            Settings::Csm(c) => c.keys(),
            Settings::Features(_) => features::KEYS,
        }
    }

    /// Sets one key from its text. `Ok(false)`: the method has no such key.
    pub fn set(&mut self, name: &str, value: &str) -> Result<bool> {
        let Some(key) = self.keys().iter().find(|k| k.name == name) else { return Ok(false) };
        let wrong = || Error::Usage(format!("`{name}={value}`: {name} takes {}", key.values));
        let choice = |options: [&str; 2]| options.iter().position(|o| *o == value).ok_or_else(wrong);
        let number =
            |low: f64, high: f64| value.parse::<f64>().ok().filter(|v| (low..=high).contains(v)).ok_or_else(wrong);
        match self {
            Settings::Certainty(c) => c.order = [Order::Sequential, Order::Batch][choice(["sequential", "batch"])?],
            Settings::DempsterShafer(d) => match name {
                "rho" if value == "1/n" => d.rho = Rho::OneOverN,
                "rho" => d.rho = Rho::Constant(number(0.0, 1.0)?),
                "model" => d.model = [MassModel::Pagac, MassModel::Murphy][choice(["pagac", "murphy"])?],
                "cap" => d.cap = number(0.0, 0.999_999)?,
                _ => d.max_occ = number(0.0, 1.0)?,
            },
            Settings::Bayes(b) => match name {
                "model" => b.model = Some([Likelihood::Murphy, Likelihood::Constant][choice(["murphy", "constant"])?]),
                "max_occ" => b.max_occ = number(0.0, 1.0)?,
                "region_one_floor" => b.region_one_floor = number(0.0, 0.98)?,
                "region_two_floor" => b.region_two_floor = number(0.0, 0.98)?,
                "p_hit" => b.p_hit = number(0.02, 0.98)?,
                "p_miss" => b.p_miss = number(0.02, 0.98)?,
                "p_occupied" => b.p_occupied = number(0.5, 1.0)?,
                _ => b.p_empty = number(0.0, 0.5)?,
            },
            Settings::Himm(h) => h.gro = choice(["false", "true"])? == 1,
            Settings::Truth => return Ok(false),
            Settings::Csm(c) => c.set(key, value)?,
            Settings::Features(f) => f.set(key, value)?,
        }
        Ok(true)
    }

    /// Every parameter with its value, in the order of [`Settings::keys`], as text that [`Settings::set`] takes.
    pub fn values(&self) -> Vec<(&'static str, String)> {
        let texts: Vec<String> = match self {
            Settings::Certainty(c) => vec![["sequential", "batch"][c.order as usize].into()],
            Settings::DempsterShafer(d) => vec![
                match d.rho {
                    Rho::OneOverN => "1/n".into(),
                    Rho::Constant(v) => v.to_string(),
                },
                ["pagac", "murphy"][d.model as usize].into(),
                d.cap.to_string(),
                d.max_occ.to_string(),
            ],
            Settings::Bayes(b) => {
                let numbers =
                    [b.max_occ, b.region_one_floor, b.region_two_floor, b.p_hit, b.p_miss, b.p_occupied, b.p_empty];
                let model = ["murphy", "constant"][b.likelihood() as usize].to_string();
                std::iter::once(model).chain(numbers.iter().map(f64::to_string)).collect()
            }
            Settings::Himm(h) => vec![h.gro.to_string()],
            Settings::Truth => Vec::new(),
            Settings::Csm(c) => c.values(),
            Settings::Features(f) => f.values(),
        };
        self.keys().iter().map(|k| k.name).zip(texts).collect()
    }
}
