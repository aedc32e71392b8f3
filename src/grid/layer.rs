//! A finished map: named layers over one grid.

use super::GridSpec;

/// The class of a cell by its method's decision rule.
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

/// The `width · height` values of a layer, row by row from the bottom.
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

    /// Whether there are no values.
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

/// The colour scale of a layer. It is fixed and does not depend on the layer's values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// From white at `low` to black at `high`.
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
    /// From dark violet at `low` through green to yellow at `high` (the colours of viridis).
    Heat {
        /// Value shown darkest.
        low: f64,
        /// Value shown brightest.
        high: f64,
    },
    /// Whole numbers: 0 is grey; 1, 2, … have a colour each.
    Classes(Palette),
}

/// The colours of class labels 1, 2, …, and of "free" after them.
#[derive(Clone, Copy, PartialEq)]
pub struct Palette {
    colours: [[u8; 3]; Palette::MOST + 1],
    classes: u8,
}

impl Palette {
    /// The largest number of class labels.
    pub const MOST: usize = 32;

    /// A palette of these colours, "free" last. `None` if there are no class labels, or more than [`Palette::MOST`].
    pub fn of(colours: &[[u8; 3]]) -> Option<Palette> {
        let classes = colours.len().checked_sub(1).filter(|n| (1..=Palette::MOST).contains(n))?;
        let mut all = [[0; 3]; Palette::MOST + 1];
        all[..colours.len()].copy_from_slice(colours);
        Some(Palette { colours: all, classes: classes as u8 })
    }

    /// A palette of one class, which is black, and white for "free".
    pub fn plain() -> Palette {
        let mut colours = [[0; 3]; Palette::MOST + 1];
        colours[1] = [255; 3];
        Palette { colours, classes: 1 }
    }

    /// Number of class labels, without "free".
    pub fn classes(&self) -> usize {
        usize::from(self.classes)
    }

    /// Red, green and blue of labels 1, 2, … and, last, of "free".
    pub fn colours(&self) -> &[[u8; 3]] {
        &self.colours[..=self.classes()]
    }
}

impl std::fmt::Debug for Palette {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.colours()).finish()
    }
}

/// A named layer.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Name of the layer in files and reports.
    pub name: String,
    /// Description in one line, with the unit.
    pub about: &'static str,
    /// The values.
    pub data: Data,
    /// The value of a cell that no reading reached.
    pub fill: f64,
    /// Colour scale.
    pub scale: Scale,
}

/// A finished map: layers over one grid. Every map has `touched` (0/1) and `class` (−1, 0, 1).
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// The grid of the cells.
    pub grid: GridSpec,
    /// The method's name.
    pub method: String,
    /// The layers, in the method's order, `touched` and `class` last.
    pub layers: Vec<Layer>,
    /// Cell updates: (reading, cell) pairs with the cell inside the cone.
    pub updates: u64,
    /// The total increment of α over all cells, one number for each label, "free" last. Empty if the method has no α.
    pub increments: Vec<f64>,
}

impl Map {
    /// The layer with this name; `None` if there is none.
    pub fn layer(&self, name: &str) -> Option<&Layer> {
        self.layers.iter().find(|l| l.name == name)
    }
}
