//! Things by the squares of the plane that they lie in, so that a question about a place looks at what is near it alone.

use crate::geometry::plane::Point;
use std::collections::HashMap;

/// Edge of a square, metres.
const SQUARE: f64 = 2.0;

/// Things at places, in the order they came.
#[derive(Debug, Clone)]
pub struct Near<T> {
    squares: HashMap<[i64; 2], Vec<u32>>,
    things: Vec<T>,
}

impl<T> Default for Near<T> {
    fn default() -> Self {
        Near { squares: HashMap::new(), things: Vec::new() }
    }
}

fn square(at: Point) -> [i64; 2] {
    [at.0, at.1].map(|v| (v / SQUARE).floor() as i64)
}

impl<T: Clone> Near<T> {
    /// Puts a thing at a place.
    pub fn push(&mut self, at: Point, thing: T) {
        self.squares.entry(square(at)).or_default().push(self.things.len() as u32);
        self.things.push(thing);
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.things.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.things.is_empty()
    }

    /// All, in the order they came.
    pub fn all(&self) -> &[T] {
        &self.things
    }

    /// The middles of the squares that hold some, from left to right and from the bottom up; so many metres across.
    pub fn squares(&self) -> (Vec<Point>, f64) {
        let mut squares: Vec<[i64; 2]> = self.squares.keys().copied().collect();
        squares.sort_unstable();
        (squares.into_iter().map(|[i, j]| ((i as f64 + 0.5) * SQUARE, (j as f64 + 0.5) * SQUARE)).collect(), SQUARE)
    }

    /// The places in the list of those in the squares that a box x0, y0, x1, y1 meets, in the order they came.
    pub fn within(&self, [x0, y0, x1, y1]: [f64; 4]) -> Vec<u32> {
        let ([i0, j0], [i1, j1]) = (square((x0, y0)), square((x1, y1)));
        let many = (i1.saturating_sub(i0).saturating_mul(j1.saturating_sub(j0))) as usize > self.squares.len();
        let mut found: Vec<u32> = if many {
            let inside = |s: &[i64; 2]| (i0..=i1).contains(&s[0]) && (j0..=j1).contains(&s[1]);
            self.squares.iter().filter(|(s, _)| inside(s)).flat_map(|(_, own)| own).copied().collect()
        } else {
            let squares = (j0..=j1).flat_map(|j| (i0..=i1).map(move |i| [i, j]));
            squares.filter_map(|s| self.squares.get(&s)).flatten().copied().collect()
        };
        found.sort_unstable();
        found
    }
}
