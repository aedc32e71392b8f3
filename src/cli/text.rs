//! Printed text: entries of a list, counts, and parameters with angles in degrees, lengths in metres and four significant digits.

use super::print_line;
use crate::support::wrap::wrap;

/// Prints an entry of a list: its subject and its text, in lines of 100 columns.
pub fn print_item(subject: &str, text: &str) {
    print_line!("{}", wrap(&format!("{subject:<10}{text}"), 10));
}

/// A count with its noun; the plural ends in s.
pub fn count(n: u64, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// Formats a parameter's value as the report lists it: one number, or one of each sensor, separated by spaces.
pub fn format_value(key: &str, value: &str) -> String {
    let numbers: Option<Vec<f64>> = value.split(' ').map(|v| v.parse().ok()).collect();
    let Some(numbers) = numbers else { return value.into() };
    let each: Vec<String> = numbers.iter().map(|v| one(key, *v)).collect();
    each.join(", ")
}

fn one(key: &str, value: f64) -> String {
    match key {
        "beta" | "w_beam" => format!("{} deg", rounded(value.to_degrees())),
        "resolution" | "r_min" | "r_max" | "hit_range" | "no_echo_range" | "epsilon" | "step" | "w_obstacle"
        | "z_max" | "l" | "hold" => format!("{} m", rounded(value)),
        _ => rounded(value),
    }
}

/// A number with four significant digits, without trailing zeros.
fn rounded(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let digits = (3 - value.abs().log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_their_units_and_few_digits() {
        for (key, value, wanted) in [
            ("beta", "0.2181661564992912", "12.5 deg"),
            ("w_beam", "0.04724199479082399", "2.707 deg"),
            ("r_max", "4", "4 m"),
            ("r_min", "0.17 0.2", "0.17 m, 0.2 m"),
            ("hit_range", "81.91", "81.91 m"),
            ("resolution", "0.0001", "0.0001 m"),
            ("epsilon", "0.30000000000000004", "0.3 m"),
            ("w_obstacle", "2 cells", "2 cells"),
            ("max_occ", "0.98", "0.98"),
            ("rho", "1/n", "1/n"),
            ("neighbours", "16", "16"),
            ("hold", "1000", "1000 m"),
            ("sigma0", "0.00001", "0.00001"),
        ] {
            assert_eq!(format_value(key, value), wanted, "{key} = {value}");
        }
    }
}
