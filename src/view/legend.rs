//! The legend of a layer's colours, as the page draws it.

use super::protocol::Legend;
use crate::grid::Scale;
use crate::output::png::{UNDECIDED, UNTOUCHED, colour};
use crate::output::tidy;

/// A scale's legend: evenly spaced stops of a gradient, or the classes' colours. `classes` names labels 1, 2, … and "free", which is last;
/// labels without a name are numbered.
pub fn legend(scale: Scale, classes: &[String]) -> Legend {
    let gradient = |low: f64, high: f64, stops: u32| {
        let value = |k: u32| low + (high - low) * f64::from(k) / f64::from(stops - 1);
        let stops = (0..stops).map(|k| (tidy(value(k)).to_string(), css(colour(scale, value(k))))).collect();
        Legend::Scale { stops, untouched: css(UNTOUCHED) }
    };
    match scale {
        Scale::Grey { low, high } => gradient(low, high, 2),
        Scale::Signed { limit } => gradient(-limit, limit, 3),
        // viridis is not linear between its ends
        Scale::Heat { low, high } => gradient(low, high, 9),
        Scale::Classes(palette) => {
            let last = palette.classes();
            let name = |k: usize| match classes.get(k) {
                Some(name) => name.clone(),
                None if k == last => "free".into(),
                None => format!("class {}", k + 1),
            };
            let labels = palette.colours().iter().enumerate().map(|(k, c)| (name(k), *c));
            class_legend([("undecided".to_string(), UNDECIDED)].into_iter().chain(labels))
        }
    }
}

/// The legend of named colours.
pub(super) fn class_legend(entries: impl Iterator<Item = (String, [u8; 3])>) -> Legend {
    let entries = entries.map(|(name, colour)| (name, css(colour))).collect();
    Legend::Classes { entries, untouched: css(UNTOUCHED) }
}

/// A colour in CSS notation.
fn css([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Palette;
    use serde_json::{Value, json};

    fn sent(scale: Scale, classes: &[String]) -> Value {
        serde_json::to_value(legend(scale, classes)).expect("it is JSON")
    }

    #[test]
    fn a_scale_has_its_ends_and_classes_their_names() {
        let signed = sent(Scale::Signed { limit: 1.0 }, &[]);
        assert_eq!(signed["stops"], json!([["-1", "#0101ff"], ["0", "#ffffff"], ["1", "#ff0101"]]));
        assert_eq!((&signed["kind"], &signed["untouched"]), (&json!("scale"), &json!("#a8b4c4")));
        let grey = sent(Scale::Grey { low: 0.0, high: 0.5 }, &[]);
        assert_eq!(grey["stops"], json!([["0", "#ffffff"], ["0.5", "#010101"]]));
        let named = sent(Scale::Classes(Palette::plain()), &["wall".to_string()]);
        assert_eq!(named["entries"], json!([["undecided", "#808080"], ["wall", "#000000"], ["free", "#ffffff"]]));
    }
}
