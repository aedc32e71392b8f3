//! A campus of any size from a seed: streets around blocks, in each block a building with a corridor, and rooms with a door
//! and a piece of furniture each. The path covers streets, corridors and rooms.

use super::random::Random;
use super::shape::{Surface, Wall};
use super::text::Table;
use crate::geometry::plane::Point;
use crate::support::memory;
use crate::{Error, Result};

/// Memory of a block's walls, corners and poses, bytes: as measured, and a tenth more.
const BLOCK_BYTES: u64 = 65_000;
/// Distances from one block to the next along x and y, metres.
const BLOCK: [f64; 2] = [34.0, 20.0];
/// Width of a street, metres.
const STREET: f64 = 4.0;
/// Width of a corridor and of its entrances, metres.
const CORRIDOR: f64 = 2.2;
/// Width of a door, metres.
const DOOR: f64 = 0.95;

/// The table `[campus]`: sizes in metres.
pub(crate) struct Campus {
    seed: u64,
    width: f64,
    height: f64,
}

impl Campus {
    /// Reads the table, and checks that the campus fits into memory.
    ///
    /// # Errors
    /// [`Error::Input`] for a value out of its range; [`Error::Resources`] where memory doesn't suffice.
    pub fn read(table: &Table<'_>) -> Result<Campus> {
        table.check(&["seed", "width", "height"])?;
        let side = |key: &str, least: f64| {
            let v = table.need(key, table.positive(key)?, "200.0")?;
            if v >= least && v <= 20_000.0 {
                return Ok(v);
            }
            Err(table.fail(key, format!("{key} = {v}: a campus takes {least} to 20000 m")))
        };
        let (width, height) = (side("width", BLOCK[0] + STREET)?, side("height", BLOCK[1] + STREET)?);
        let needed = (width * height / (BLOCK[0] * BLOCK[1])) as u64 * BLOCK_BYTES;
        if let Some(free) = memory::available().filter(|free| needed > *free) {
            let (needed, free) = (memory::format_size(needed), memory::format_size(free));
            return Err(Error::Resources(format!(
                "a campus of {width} × {height} m needs {needed}, but this machine has {free} free: make it smaller"
            )));
        }
        Ok(Campus { seed: table.count("seed")?.unwrap_or(1), width, height })
    }
}

/// The walls of a campus, and the way points of a path through it.
pub(crate) struct Built {
    pub walls: Vec<Wall>,
    pub path: Vec<Point>,
    wall: Option<u16>,
    furniture: Option<u16>,
}

/// A building's outer walls, metres.
#[derive(Clone, Copy)]
struct Building {
    x0: f64,
    y0: f64,
    x1: f64,
    y1: f64,
}

/// Builds a campus; `wall` and `furniture` are the classes of its walls and its furniture.
pub(crate) fn build(campus: &Campus, [wall, furniture]: [Option<u16>; 2]) -> Built {
    let mut built = Built { walls: Vec::new(), path: Vec::new(), wall, furniture };
    let columns = ((campus.width - STREET) / BLOCK[0]).floor() as u64;
    let rows = ((campus.height - STREET) / BLOCK[1]).floor() as u64;
    for row in 0..rows {
        let y0 = STREET + row as f64 * BLOCK[1];
        built.path.push(Point::new(STREET / 2.0, y0 - STREET / 2.0));
        for column in 0..columns {
            let mut random = Random::new(campus.seed ^ Random::new(row << 32 | column).bits());
            let x0 = STREET + column as f64 * BLOCK[0];
            let (x1, y1) = (x0 + BLOCK[0] - STREET, y0 + BLOCK[1] - STREET);
            built.building(&mut random, Building { x0, y0, x1, y1 });
        }
        // back along the street above
        let (far, above) = (STREET / 2.0 + columns as f64 * BLOCK[0], y0 + BLOCK[1] - STREET / 2.0);
        built.path.extend([Point::new(far, above), Point::new(STREET / 2.0, above)]);
    }
    let (right, top) = (columns as f64 * BLOCK[0] + STREET, rows as f64 * BLOCK[1] + STREET);
    built.polyline(&[(0.0, 0.0), (right, 0.0), (right, top), (0.0, top), (0.0, 0.0)]);
    built
}

impl Built {
    /// Thin walls from each point to the next.
    fn polyline(&mut self, points: &[(f64, f64)]) {
        for p in points.windows(2) {
            let [a, b] = [p[0], p[1]].map(|(x, y)| Point::new(x, y));
            self.walls.push(Wall { a, b, surface: Surface::Specular, class: self.wall, thin: true });
        }
    }

    /// A building with a corridor from left to right; the path leads through the corridor and into every room.
    fn building(&mut self, random: &mut Random, Building { x0, y0, x1, y1 }: Building) {
        let shift = random.uniform(-1.5, 1.5);
        let middle = (y0 + y1) / 2.0 + shift;
        let (low, high) = (middle - CORRIDOR / 2.0, middle + CORRIDOR / 2.0);
        self.polyline(&[(x0, low), (x0, y0), (x1, y0), (x1, low)]);
        self.polyline(&[(x0, high), (x0, y1), (x1, y1), (x1, high)]);
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
                self.polyline(&[(from, wall), (door - DOOR / 2.0, wall)]);
                from = door + DOOR / 2.0;
                if next < x1 {
                    self.polyline(&[(next, wall), (next, end)]);
                }
                let depth = (end - wall) * random.uniform(0.45, 0.7);
                let inside = Point::new(door, wall + depth);
                let across = Point::new(if door - x > next - door { x + 0.9 } else { next - 0.9 }, inside.y);
                doors.push((door, inside, across));
                self.furniture(random, (x, next), end, (end - wall).signum());
                x = next;
            }
            self.polyline(&[(from, wall), (x1, wall)]);
        }
        doors.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.path.push(Point::new(x0 - STREET / 2.0, middle));
        for (x, inside, across) in doors {
            let door = Point::new(x, middle);
            self.path.extend([door, inside, across, inside, door]);
        }
        self.path.push(Point::new(x1 + STREET / 2.0, middle));
    }

    /// A box near the far wall of a room.
    fn furniture(&mut self, random: &mut Random, (x0, x1): (f64, f64), end: f64, up: f64) {
        let (w, h) = (random.uniform(0.4, 1.2), random.uniform(0.3, 0.6));
        let x = random.uniform(x0 + 0.3, x1 - 0.3 - w);
        let (near, far) = (end - up * (0.15 + h), end - up * 0.15);
        let (bottom, top) = (near.min(far), near.max(far));
        let corners = [(x, bottom), (x, top), (x + w, top), (x + w, bottom), (x, bottom)];
        for p in corners.windows(2) {
            // clockwise: free outside
            let [a, b] = [p[0], p[1]].map(|(x, y)| Point::new(x, y));
            self.walls.push(Wall { a, b, surface: Surface::Specular, class: self.furniture, thin: false });
        }
    }
}
