//! What a finished map holds: named layers over one grid.

use super::GridSpec;

/// A cell's class, by its method's decision rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i8)]
pub enum Class {
    /// Seen empty.
    Empty = -1,
    /// Not seen, or undecided.
    Unknown = 0,
    /// Seen occupied.
    Occupied = 1,
}

/// A layer's values, row by row from the bottom, `width · height` of them.
#[derive(Debug, Clone, PartialEq)]
pub enum Data {
    /// Evidence, probabilities, log odds.
    F32(Vec<f32>),
    /// Counts.
    U32(Vec<u32>),
    /// Flags: 0 or 1.
    U8(Vec<u8>),
    /// Classes: 1 occupied, 0 unknown, −1 empty.
    I8(Vec<i8>),
}

impl Data {
    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Data::F32(v) => v.len(),
            Data::U32(v) => v.len(),
            Data::U8(v) => v.len(),
            Data::I8(v) => v.len(),
        }
    }

    /// Whether there is no value.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Value `k` as f64.
    pub fn get(&self, k: usize) -> f64 {
        match self {
            Data::F32(v) => f64::from(v[k]),
            Data::U32(v) => f64::from(v[k]),
            Data::U8(v) => f64::from(v[k]),
            Data::I8(v) => f64::from(v[k]),
        }
    }
}

/// How a layer is coloured, on a fixed scale that doesn't depend on its values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// White at `low` to black at `high`.
    Grey {
        /// Value shown white.
        low: f64,
        /// Value shown black.
        high: f64,
    },
    /// Blue (empty) at −`limit`, white at 0, red (occupied) at +`limit`.
    Signed {
        /// Magnitude of the strongest colour.
        limit: f64,
    },
    /// Dark violet at `low` over green to yellow at `high` (the colours of viridis).
    Heat {
        /// Value shown darkest.
        low: f64,
        /// Value shown brightest.
        high: f64,
    },
    /// Whole numbers: 0 grey, 1, 2, … each its own colour.
    Classes(Palette),
}

/// The colours of class labels 1, 2, …, and of "free" after them.
#[derive(Clone, Copy, PartialEq)]
pub struct Palette {
    colours: [[u8; 3]; Palette::MOST + 1],
    classes: u8,
}

impl Palette {
    /// Class labels at most.
    pub const MOST: usize = 32;

    /// Of these colours, "free" last; `None` where there are none, or more than [`Palette::MOST`] before the last.
    pub fn of(colours: &[[u8; 3]]) -> Option<Palette> {
        let classes = colours.len().checked_sub(1).filter(|n| (1..=Palette::MOST).contains(n))?;
        let mut all = [[0; 3]; Palette::MOST + 1];
        all[..colours.len()].copy_from_slice(colours);
        Some(Palette { colours: all, classes: classes as u8 })
    }

    /// One class, black, and white for "free".
    pub fn plain() -> Palette {
        let mut colours = [[0; 3]; Palette::MOST + 1];
        colours[1] = [255; 3];
        Palette { colours, classes: 1 }
    }

    /// How many class labels there are, "free" left out.
    pub fn classes(&self) -> usize {
        usize::from(self.classes)
    }

    /// Red, green and blue of labels 1, 2, …, "free" last.
    pub fn colours(&self) -> &[[u8; 3]] {
        &self.colours[..=self.classes()]
    }
}

impl std::fmt::Debug for Palette {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.colours()).finish()
    }
}

/// One named layer.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Its name in files and reports.
    pub name: String,
    /// One line: what it is, in which unit.
    pub about: &'static str,
    /// The values.
    pub data: Data,
    /// The value of a cell that no reading reached.
    pub fill: f64,
    /// Its colours.
    pub scale: Scale,
}

/// A finished map: layers over one grid. Every map has `touched` (0/1) and `class` (−1, 0, 1).
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// Where the cells are.
    pub grid: GridSpec,
    /// The method's name.
    pub method: String,
    /// The layers, in the method's order, `touched` and `class` last.
    pub layers: Vec<Layer>,
    /// Cell updates: (reading, cell) pairs with the cell inside the cone.
    pub updates: u64,
    /// What all cells' α gained, where the method counts it: labels, "free" last. Else empty.
    pub increments: Vec<f64>,
}

impl Map {
    /// The layer of that name.
    pub fn layer(&self, name: &str) -> Option<&Layer> {
        self.layers.iter().find(|l| l.name == name)
    }
}
