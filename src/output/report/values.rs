//! Values of a report: rounded lengths, typed parameters, the peak of memory.

use serde_json::Value;

/// Rounds a length or an angle to 1e-9, so that no -2.8000000000000003 is shown; never −0.
pub fn tidy(value: f64) -> f64 {
    let rounded = (value * 1e9).round() / 1e9;
    if rounded.is_finite() { rounded + 0.0 } else { value }
}

/// Makes typed parameters from their texts: numbers and booleans as such, the rest as text.
pub fn parameters<K: Into<String>>(texts: impl IntoIterator<Item = (K, String)>) -> serde_json::Map<String, Value> {
    let value = |text: String| match serde_json::from_str::<Value>(&text) {
        Ok(value @ (Value::Number(_) | Value::Bool(_))) => value,
        _ => Value::String(text),
    };
    texts.into_iter().map(|(k, text)| (k.into(), value(text))).collect()
}

/// The peak of the process's resident memory so far, bytes; `None` where the system doesn't tell.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib * 1024)
}
