//! A campus of any size from a seed: streets round blocks, in each block a building with a corridor, rooms with doors and
//! a piece of furniture each; the path covers streets, corridors and rooms.

use super::random::Random;
use super::shape::{Surface, Wall};
use super::text::Part;
use crate::geometry::plane::Point;
use crate::support::memory;
use crate::{Error, Result};

/// Memory that a block's walls, corners and stops take, bytes: measured, and a tenth more.
const BLOCK_BYTES: u64 = 65_000;
/// Metres from one block to the next, across and up; the street between two is `STREET` wide.
const BLOCK: (f64, f64) = (34.0, 20.0);
const STREET: f64 = 4.0;
/// Widths of a corridor, of a door, of a building's entrance.
const CORRIDOR: f64 = 2.2;
const DOOR: f64 = 0.95;

/// `[campus]`.
pub(crate) struct Campus {
    seed: u64,
    width: f64,
    height: f64,
}

impl Campus {
    pub fn read(part: &Part<'_>) -> Result<Campus> {
        part.check(&["seed", "width", "height"])?;
        let side = |key: &str, least: f64| {
            let v = part.need(key, part.positive(key)?, "200.0")?;
            if v >= least && v <= 20_000.0 {
                return Ok(v);
            }
            Err(part.text.fail(&part.place(key), format!("{key} = {v}: a campus takes {least} to 20000 m")))
        };
        let (width, height) = (side("width", BLOCK.0 + STREET)?, side("height", BLOCK.1 + STREET)?);
        let needed = (width * height / (BLOCK.0 * BLOCK.1)) as u64 * BLOCK_BYTES;
        if let Some(free) = memory::available().filter(|free| needed > *free) {
            let (needed, free) = (memory::show(needed), memory::show(free));
            return Err(Error::Resources(format!(
                "a campus of {width} × {height} m needs {needed}, but this machine has {free} free: make it smaller"
            )));
        }
        Ok(Campus { seed: part.count("seed")?.unwrap_or(1), width, height })
    }
}

/// What was built.
pub(crate) struct Built {
    pub walls: Vec<Wall>,
    pub path: Vec<Point>,
    wall: Option<u16>,
    furniture: Option<u16>,
}

/// Builds it, its walls and its furniture of these classes.
pub(crate) fn build(campus: &Campus, [wall, furniture]: [Option<u16>; 2]) -> Built {
    let mut built = Built { walls: Vec::new(), path: Vec::new(), wall, furniture };
    let columns = ((campus.width - STREET) / BLOCK.0).floor() as u64;
    let rows = ((campus.height - STREET) / BLOCK.1).floor() as u64;
    for row in 0..rows {
        let y0 = STREET + row as f64 * BLOCK.1;
        built.path.push((STREET / 2.0, y0 - STREET / 2.0));
        for column in 0..columns {
            let mut random = Random::new(campus.seed ^ Random::new(row << 32 | column).bits());
            let x0 = STREET + column as f64 * BLOCK.0;
            built.building(&mut random, x0, y0, x0 + BLOCK.0 - STREET, y0 + BLOCK.1 - STREET);
        }
        // back along the street above
        let (far, above) = (STREET / 2.0 + columns as f64 * BLOCK.0, y0 + BLOCK.1 - STREET / 2.0);
        built.path.extend([(far, above), (STREET / 2.0, above)]);
    }
    let (right, top) = (columns as f64 * BLOCK.0 + STREET, rows as f64 * BLOCK.1 + STREET);
    built.line(&[(0.0, 0.0), (right, 0.0), (right, top), (0.0, top), (0.0, 0.0)]);
    built
}

impl Built {
    fn line(&mut self, points: &[Point]) {
        for p in points.windows(2) {
            self.walls.push(Wall { a: p[0], b: p[1], surface: Surface::Specular, class: self.wall, thin: true });
        }
    }

    /// A building with its corridor from left to right; the path goes through it, into every room and back.
    fn building(&mut self, random: &mut Random, x0: f64, y0: f64, x1: f64, y1: f64) {
        let shift = random.uniform(-1.5, 1.5);
        let middle = (y0 + y1) / 2.0 + shift;
        let (low, high) = (middle - CORRIDOR / 2.0, middle + CORRIDOR / 2.0);
        self.line(&[(x0, low), (x0, y0), (x1, y0), (x1, low)]);
        self.line(&[(x0, high), (x0, y1), (x1, y1), (x1, high)]);
        let mut doors: Vec<(f64, Point, Point)> = Vec::new();
        for (wall, end) in [(low, y0), (high, y1)] {
            let mut x = x0;
            let mut from = x0;
            while x < x1 - 1.0 {
                let mut next = x + random.uniform(3.4, 6.5);
                if next > x1 - 3.4 {
                    next = x1;
                }
                let door = random.uniform(x + 1.2, next - 1.2);
                self.line(&[(from, wall), (door - DOOR / 2.0, wall)]);
                from = door + DOOR / 2.0;
                if next < x1 {
                    self.line(&[(next, wall), (next, end)]);
                }
                let depth = (end - wall) * random.uniform(0.45, 0.7);
                let inside = (door, wall + depth);
                let across = if door - x > next - door { (x + 0.9, inside.1) } else { (next - 0.9, inside.1) };
                doors.push((door, inside, across));
                self.furniture(random, (x, next), end, (end - wall).signum());
                x = next;
            }
            self.line(&[(from, wall), (x1, wall)]);
        }
        doors.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.path.push((x0 - STREET / 2.0, middle));
        for (x, inside, across) in doors {
            self.path.extend([(x, middle), inside, across, inside, (x, middle)]);
        }
        self.path.push((x1 + STREET / 2.0, middle));
    }

    /// A box near the room's far wall.
    fn furniture(&mut self, random: &mut Random, (x0, x1): (f64, f64), end: f64, up: f64) {
        let (w, h) = (random.uniform(0.4, 1.2), random.uniform(0.3, 0.6));
        let x = random.uniform(x0 + 0.3, x1 - 0.3 - w);
        let (near, far) = (end - up * (0.15 + h), end - up * 0.15);
        let (bottom, top) = (near.min(far), near.max(far));
        let corners = [(x, bottom), (x, top), (x + w, top), (x + w, bottom), (x, bottom)];
        for p in corners.windows(2) {
            // clockwise: free outside
            self.walls.push(Wall { a: p[0], b: p[1], surface: Surface::Specular, class: self.furniture, thin: false });
        }
    }
}
