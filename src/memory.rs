//! What a run will need, checked before it is taken.

use crate::batch::PAIRS;
use crate::grid::GridSpec;
use crate::layout::{BLOCKS, CHUNK, Cone, Entry, Near, SEGMENT, TILE};
use crate::method::{self, Method, Unit};
use crate::{Error, Result};

/// A size in bytes from its text: a number with KiB, MiB, GiB, TiB, kB, MB, GB, TB or B.
pub fn parse(text: &str) -> std::result::Result<u64, String> {
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

/// A size for people.
pub fn show(bytes: u64) -> String {
    match bytes as f64 {
        b if b < 1048576.0 => format!("{:.0} KiB", b / 1024.0),
        b if b < 1073741824.0 => format!("{:.0} MiB", b / 1048576.0),
        b if b < 1e13 => format!("{:.1} GiB", b / 1073741824.0),
        b => format!("{:.0} TiB", b / 1099511627776.0),
    }
}

/// Memory that the system would give now, bytes, where it tells.
pub fn available() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|l| l.starts_with("MemAvailable:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kib| kib * 1024)
}

/// Space that is free where a folder lies, bytes, where the system tells.
pub fn space(folder: &std::path::Path) -> Option<u64> {
    #[cfg(unix)]
    return rustix::fs::statvfs(folder).ok().map(|s| s.f_bavail.saturating_mul(s.f_frsize));
    #[cfg(not(unix))]
    return None;
}

/// What mapping takes, bytes, if readings reach every chunk of the grid: the cells, the layers, one batch.
pub fn needed(grid: &GridSpec, method: &dyn Method, batch: usize) -> u64 {
    let edge = TILE * CHUNK;
    let chunks = (grid.width.div_ceil(edge) * grid.height.div_ceil(edge)) as u64;
    let state = chunks * (method::tile_words(method) * CHUNK * CHUNK * 4) as u64;
    // Layers and the combined one in f32, two counts, touched, class; then a copy of a layer to write.
    let layers = grid.cells() as u64 * (4 * (method.layers().len() as u64 + 1) + 8 + 2 + 4);
    // An update as it comes, and snapped: some tens of points.
    let updates = if method.unit() == Unit::Update { batch as u64 * 2048 } else { 0 };
    state + layers + batched(batch) + updates
}

/// What the whole-log way takes, bytes, apart from the readings that it may spill: three chunks of cells on their way and a spare one, with
/// their layers and one that is written; batches on both sides of a kernel; what it found for each reading; scans' poses; the pictures.
pub fn whole(grid: &GridSpec, method: &dyn Method, batch: usize, readings: u64, scans: u64) -> u64 {
    let edge = TILE * CHUNK;
    let cells = (grid.width.min(edge) * grid.height.min(edge)) as u64;
    let words = (method::tile_words(method) * CHUNK * CHUNK * 4) as u64;
    let layers = cells * (4 * (method.layers().len() as u64 + 1) + 8 + 2 + 4);
    let batch = batch.min(usize::try_from(readings).unwrap_or(usize::MAX));
    let found = if method.rounds().is_some_and(|r| r.len() > 1) { 4 * readings } else { 0 };
    // A pose, how far its beams reach, where they lie, its place in the tree; scans that are snapped.
    let poses = if method.unit() == Unit::Scan { 128 * scans + (1 << 25) } else { 0 };
    4 * words + 3 * layers + 3 * batched(batch) + found + poses + (1 << 24)
}

/// What the whole-log way takes on a card, bytes: the cells of a chunk, of two that were handed over, and of one on its way back; the
/// buffers of a batch, rounded up. No adapter tells how much it has free.
pub fn card(method: &dyn Method, batch: usize) -> u64 {
    let words = (method::tile_words(method) * CHUNK * CHUNK * 4) as u64;
    let cone = size_of::<Cone>() + size_of::<Near>() + size_of::<[u32; 4]>() + BLOCKS * BLOCKS * size_of::<u32>();
    let pair = size_of::<Entry>() + size_of::<f32>();
    4 * words + 2 * (batch.next_multiple_of(SEGMENT) * cone + PAIRS * pair) as u64
}

/// Readings at a time in the whole-log way: no more than `batch`, and so few that batches take a third of `limit`.
pub fn whole_batch(batch: usize, limit: u64) -> usize {
    let fits = |n: &usize| 3 * batched(*n) <= limit / 3;
    (10..).map(|k| 1usize << k).take_while(|n| *n <= batch && fits(n)).last().unwrap_or(batch.min(1 << 10))
}

/// What a batch takes, bytes.
fn batched(batch: usize) -> u64 {
    // A cone, and its pairs with tiles, twice while they are merged; with certainty a sum's parts. A box of 64 tiles a
    // reading is ample for 5 m on 5 cm, and no batch comes to more than PAIRS.
    let pairs = (batch as u64 * 64).min(PAIRS as u64);
    batch as u64 * 80 + pairs * (2 * 24 + 8 + 64)
}

/// Fails where a run needs more than the cap, or than the machine has; `remedy` says what to do.
pub fn check(needed: u64, cap: Option<u64>, grid: &GridSpec, remedy: &str) -> Result<()> {
    let limit = match (cap, available()) {
        (Some(cap), _) if needed > cap => format!("--memory allows {}", show(cap)),
        (_, Some(free)) if needed > free => format!("this machine has {} free", show(free)),
        _ => return Ok(()),
    };
    let (width, height, resolution) = (grid.width, grid.height, grid.resolution);
    Err(Error::Resources(format!(
        "a map of {width} × {height} cells of {resolution} m needs {}, but {limit}: {remedy}",
        show(needed)
    )))
}

#[cfg(test)]
mod tests {
    #[test]
    fn sizes() {
        assert_eq!(super::parse("4GiB"), Ok(4 << 30));
        assert_eq!(super::parse("1.5 kB"), Ok(1500));
        assert_eq!(super::parse("1024"), Ok(1024));
        for bad in ["", "GiB", "-1MB", "4 gigs", "nan"] {
            assert!(super::parse(bad).is_err(), "{bad}");
        }
    }
}
