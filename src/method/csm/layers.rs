//! The layers of a cell's Dirichlet distribution: mean, variance, class and α.

use crate::grid::{Class, Palette, Scale};
use crate::method::LayerSpec;
use crate::method::settings::Csm;

/// The largest difference at which two α are a tie.
const TIE: f64 = 1e-6;

/// Names of the layers of α.
pub(crate) const ALPHA: [&str; MOST] = [
    "alpha_1", "alpha_2", "alpha_3", "alpha_4", "alpha_5", "alpha_6", "alpha_7", "alpha_8", "alpha_9", "alpha_10",
    "alpha_11", "alpha_12", "alpha_13", "alpha_14", "alpha_15", "alpha_16", "alpha_17", "alpha_18", "alpha_19",
    "alpha_20", "alpha_21", "alpha_22", "alpha_23", "alpha_24", "alpha_25", "alpha_26", "alpha_27", "alpha_28",
    "alpha_29", "alpha_30", "alpha_31", "alpha_32", "alpha_33",
];

/// The largest number of α of a cell.
pub(super) const MOST: usize = Palette::MOST + 1;

/// The α of a cell, for labels 1, 2, … and, last, for "free".
pub(super) struct Dirichlet {
    alpha: [f64; MOST],
    classes: usize,
}

impl Dirichlet {
    /// The distribution with these increments over the prior.
    pub fn of(csm: &Csm, increments: &[f64]) -> Dirichlet {
        let mut alpha = [0.0; MOST];
        alpha.iter_mut().zip(increments).for_each(|(a, gain)| *a = csm.prior + gain);
        Dirichlet { alpha, classes: increments.len() }
    }

    /// Writes mean, variance, label and every α to `layers`, and returns the class.
    pub fn values(&self, layers: &mut [f32]) -> Class {
        let [labels @ .., free] = &self.alpha[..self.classes] else { return Class::Unknown };
        let sum: f64 = self.alpha[..self.classes].iter().sum();
        let (best, top) =
            labels.iter().enumerate().fold((0, labels[0]), |b, (k, a)| if *a > b.1 { (k, *a) } else { b });
        let class = match top - free {
            d if d > TIE => Class::Occupied,
            d if d < -TIE => Class::Empty,
            _ => Class::Unknown,
        };
        let p = top.max(*free) / sum;
        layers[0] = (labels.iter().sum::<f64>() / sum) as f32;
        layers[1] = (p * (1.0 - p) / (sum + 1.0)) as f32;
        layers[2] = match class {
            Class::Occupied => best as f32 + 1.0,
            Class::Empty => self.classes as f32,
            Class::Unknown => 0.0,
        };
        layers[3..].iter_mut().zip(&self.alpha).for_each(|(layer, a)| *layer = *a as f32);
        class
    }
}

/// The layers, in the order of [`Dirichlet::values`].
pub(super) fn specs(csm: &Csm) -> Vec<LayerSpec> {
    let classes = csm.labels() + 1;
    let mut start = vec![0.0; 3 + classes];
    Dirichlet::of(csm, &vec![0.0; classes]).values(&mut start);
    let palette = if csm.semantic { csm.palette } else { Palette::plain() };
    // The variance of a probability is at most 0.25.
    let variance = Scale::Heat { low: 0.0, high: 0.25 };
    let first = [
        ("mean", "probability of occupied: the mean of the Dirichlet", Scale::Grey { low: 0.0, high: 1.0 }),
        ("variance", "variance of the probability of the likeliest class", variance),
        ("label", "likeliest class: labels from 1, free after the last; 0 undecided", Scale::Classes(palette)),
    ];
    let alpha = ALPHA[..classes].iter().map(|name| {
        let about = "alpha of the class of that number, free the last: its prior and what readings added";
        (*name, about, Scale::Grey { low: 0.0, high: if csm.continuous { 1.0 } else { 10.0 } })
    });
    let layers = first.into_iter().chain(alpha).zip(start);
    layers
        .map(|((name, about, scale), fill)| LayerSpec { name, about, fill, scale, integer: name == "label" })
        .collect()
}
