//! Parses lengths and angles: a plain number, or a number with a unit.
//!
//! Lengths are metres unless they end in `mm`, `cm` or `m`; angles are radians unless they end in `deg` (or `rad`).

/// Metres from `0.18`, `0.18m`, `18cm` or `180 mm`.
///
/// # Errors
/// A text that says how to write a length.
pub fn length(text: &str) -> Result<f64, String> {
    number(text, &[("mm", 1000.0), ("cm", 100.0), ("m", 1.0)], |value, per| value / per)
        .ok_or_else(|| "takes a length: a number in metres, or one that ends in mm, cm or m".into())
}

/// Radians from `0.2`, `0.2rad` or `12.5deg`.
///
/// # Errors
/// A text that says how to write an angle.
pub fn angle(text: &str) -> Result<f64, String> {
    number(text, &[("deg", 180.0), ("rad", 0.0)], |value, per| if per > 0.0 { value.to_radians() } else { value })
        .ok_or_else(|| "takes an angle: a number in radians, or one that ends in deg".into())
}

/// A finite number with one of the units, the longer unit first in the list.
fn number(text: &str, units: &[(&str, f64)], convert: fn(f64, f64) -> f64) -> Option<f64> {
    let text = text.trim();
    let parse = |t: &str| t.trim_end().parse::<f64>().ok().filter(|v| v.is_finite());
    match units.iter().find_map(|(unit, per)| text.strip_suffix(unit).map(|rest| (rest, *per))) {
        Some((rest, per)) => parse(rest).map(|value| convert(value, per)),
        None => parse(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units() {
        for text in ["0.18", "0.18m", "18cm", "18 cm", "180mm", " 180 mm "] {
            assert_eq!(length(text).unwrap(), 0.18, "{text}");
        }
        assert_eq!(angle("12.5deg").unwrap(), 12.5_f64.to_radians());
        assert_eq!(angle("-0.2rad").unwrap(), -0.2);
        for text in ["", "m", "1km", "1e999", "inf", "nan", "12.5deg"] {
            assert!(length(text).unwrap_err().contains("mm, cm or m"), "{text}");
        }
        for text in ["", "deg", "12°", "infdeg", "3m"] {
            assert!(angle(text).unwrap_err().contains("deg"), "{text}");
        }
    }
}
