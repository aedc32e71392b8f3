//! Free memory and disk space of the machine; sizes in bytes as text.

/// Parses a size in bytes: a number with KiB, MiB, GiB, TiB, kB, MB, GB, TB or B.
pub fn parse_size(text: &str) -> Result<u64, String> {
    const UNITS: [(&str, f64); 9] = [
        ("KiB", 1024.0),
        ("MiB", 1048576.0),
        ("GiB", 1073741824.0),
        ("TiB", 1099511627776.0),
        ("kB", 1e3),
        ("MB", 1e6),
        ("GB", 1e9),
        ("TB", 1e12),
        ("B", 1.0),
    ];
    let (unit, scale) = UNITS.iter().find(|(unit, _)| text.ends_with(unit)).copied().unwrap_or(("", 1.0));
    match text[..text.len() - unit.len()].trim().parse::<f64>() {
        Ok(value) if value > 0.0 && value * scale < 1e18 => Ok((value * scale) as u64),
        _ => Err(format!("{text} is not a size: give a number with a unit, such as 4GiB or 500MB")),
    }
}

/// A size in KiB, MiB, GiB or TiB.
pub fn format_size(bytes: u64) -> String {
    match bytes as f64 {
        b if b < 1048576.0 => format!("{:.0} KiB", b / 1024.0),
        b if b < 1073741824.0 => format!("{:.0} MiB", b / 1048576.0),
        b if b < 1e13 => format!("{:.1} GiB", b / 1073741824.0),
        b => format!("{:.0} TiB", b / 1099511627776.0),
    }
}

/// Available memory, bytes; `None` where the system doesn't tell.
pub fn available() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|l| l.starts_with("MemAvailable:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kib| kib * 1024)
}

/// Free space of the disk of a folder, bytes; `None` where the system doesn't tell.
pub fn free_space(folder: &std::path::Path) -> Option<u64> {
    #[cfg(unix)]
    return rustix::fs::statvfs(folder).ok().map(|s| s.f_bavail.saturating_mul(s.f_frsize));
    #[cfg(not(unix))]
    return None;
}

#[cfg(test)]
mod tests {
    #[test]
    fn sizes() {
        assert_eq!(super::parse_size("4GiB"), Ok(4 << 30));
        assert_eq!(super::parse_size("1.5 kB"), Ok(1500));
        assert_eq!(super::parse_size("1024"), Ok(1024));
        for bad in ["", "GiB", "-1MB", "4 gigs", "nan"] {
            assert!(super::parse_size(bad).is_err(), "{bad}");
        }
    }
}
