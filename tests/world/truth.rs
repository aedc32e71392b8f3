//! True maps: areas by an independent rule, whole-cell shifts, hidden surfaces.

use echogrid::geometry::plane::Point;
use echogrid::grid::GridSpec;
use echogrid::world::{World, true_map};
use std::path::Path;

fn world(text: &str) -> World {
    World::parse(Path::new("test.toml"), text).unwrap()
}

fn room(dx: f64, dy: f64, more: &str) -> World {
    let p = |x: f64, y: f64| format!("[{}, {}]", x + dx, y + dy);
    let outline = [p(0.02, 0.03), p(4.62, 0.03), p(4.62, 3.43), p(0.02, 3.43), p(0.02, 0.03)].join(", ");
    world(&format!("[[outline]]\npoints = [{outline}]\n{more}\n[path]\nposes = [{}, {}]\n", p(1.5, 1.3), p(3.2, 2.0)))
}

fn count(map: &[i8], class: i8) -> usize {
    map.iter().filter(|c| **c == class).count()
}

#[test]
fn a_polygons_area_is_counted_otherwise() {
    // an L: its empty cells by centre in polygon (even-odd), its walls by a fine walk along them; all in sight of the scans
    let corners = [(0.03, 0.02), (4.03, 0.02), (4.03, 1.52), (1.53, 1.52), (1.53, 3.02), (0.03, 3.02)];
    let text: Vec<String> = corners.iter().chain([&corners[0]]).map(|(x, y)| format!("[{x}, {y}]")).collect();
    let world =
        world(&format!("[[outline]]\npoints = [{}]\n[path]\nposes = [[0.7, 0.7], [3.0, 0.8]]\n", text.join(", ")));
    for resolution in [0.1, 0.05, 0.023] {
        let grid = GridSpec::from_bounds([-0.5, -0.5, 4.5, 3.5], resolution).unwrap();
        let map = true_map(&world, &world.scans(), &grid, 10.0);
        let mut wall = vec![false; grid.cells()];
        for k in 0..6 {
            let (a, b) = (corners[k], corners[(k + 1) % 6]);
            for n in 0..200_000 {
                let t = (f64::from(n) + 0.5) / 200_000.0;
                let at = |p: f64, q: f64, low: f64| ((p + (q - p) * t - low) / resolution).floor() as usize;
                wall[at(a.1, b.1, -0.5) * grid.width + at(a.0, b.0, -0.5)] = true;
            }
        }
        let mut empty = 0.0;
        for k in 0..grid.cells() {
            let (x, y) = grid.centre(k % grid.width, k / grid.width);
            let inside = (0..6).filter(|&i| {
                let (a, b) = (corners[i], corners[(i + 1) % 6]);
                (a.1 > y) != (b.1 > y) && x < a.0 + (y - a.1) / (b.1 - a.1) * (b.0 - a.0)
            });
            let want = if wall[k] {
                1
            } else if inside.count() % 2 == 1 {
                -1
            } else {
                0
            };
            assert_eq!(map[k], want, "cell at {x}, {y} of {resolution} m");
            empty += if want == -1 { resolution * resolution } else { 0.0 };
        }
        // area 4·1.5 + 1.5·1.5 = 8.25, less about half a cell along the perimeter of 14 m
        assert!((empty + 7.0 * resolution - 8.25).abs() < 5.0 * resolution, "{empty} m² at {resolution} m");
    }
}

#[test]
fn whole_cells_shift_everything() {
    let grid = |dx: f64, dy: f64| GridSpec::from_bounds([-1.0 + dx, -1.0 + dy, 6.0 + dx, 5.0 + dy], 0.25).unwrap();
    let (here, there) = (room(0.0, 0.0, ""), room(2.5, -1.25, ""));
    let one = true_map(&here, &here.scans(), &grid(0.0, 0.0), 5.0);
    let two = true_map(&there, &there.scans(), &grid(2.5, -1.25), 5.0);
    assert_eq!(one, two);
}

#[test]
fn what_is_hidden_or_far_is_unknown() {
    let more = "[[box]]\ncentre = [2.3, 1.0]\nsize = [0.4, 0.4]\n[[circle]]\ncentre = [4.0, 3.0]\nradius = 0.2\n";
    let world = room(0.0, 0.0, more);
    let grid = GridSpec::from_bounds([0.0, 0.0, 5.0, 4.0], 0.1).unwrap();
    let map = true_map(&world, &[Point::new(1.5, 1.05)], &grid, 5.0);
    let at = |x: f64, y: f64| map[(y / 0.1) as usize * grid.width + (x / 0.1) as usize];
    // the box's left face is seen, its right face and the wall behind it are not; its inside never
    assert_eq!([at(2.15, 1.05), at(2.55, 1.05), at(4.65, 1.05), at(3.5, 1.05), at(2.3, 1.0)], [1, 0, 0, 0, 0]);
    assert_eq!([at(1.05, 1.05), at(0.05, 1.05), at(4.95, 3.95)], [-1, 1, 0]);
    // the circle: its near side, not its far side
    assert_eq!([at(3.85, 2.85), at(4.15, 3.15)], [1, 0]);
    let near = true_map(&world, &[Point::new(1.5, 1.05)], &grid, 1.0);
    assert!(count(&near, -1) < count(&map, -1) && near[10 * grid.width] == 0, "beyond 1 m nothing is known");
}

#[test]
fn a_wall_that_the_range_only_touches_is_not_seen() {
    let grid = GridSpec::from_bounds([-10.0, -1.0, 10.0, 7.0], 0.1).unwrap();
    let mut state = 9u64;
    for _ in 0..40 {
        // two decimals, as people write them
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let (x, y) = (((state >> 33) % 400) as f64 / 100.0 - 2.0, ((state >> 45) % 100) as f64 / 100.0);
        let text =
            format!("[[wall]]\npoints = [[{}, {}], [8.53, {1}]]\n[path]\nposes = [[{x}, {y}]]\n", x - 3.4, y + 5.0);
        let world = world(&text);
        let seen = count(&true_map(&world, &world.scans(), &grid, 5.0), 1);
        assert!(seen <= 2, "{seen} cells of a wall 5 m off, from ({x}, {y})");
    }
}

#[test]
fn arcs_pass_through_the_cells_that_they_pass_through() {
    // by a fine walk along the circle itself, from inside and outside; a quarter of it too
    for (free, span) in [("inside", 1.0), ("outside", 1.0), ("outside", 0.25)] {
        let part = if span < 1.0 { "from = 0\nto = \"90deg\"".into() } else { format!("free = \"{free}\"") };
        let poses = match free {
            "inside" => "[[0.011, 0.013]]",
            _ => "[[2.0, 2.1], [-2.2, 1.9], [-2.0, -2.3], [2.1, -1.8]]",
        };
        let text = format!("[[circle]]\ncentre = [0, 0]\nradius = 0.5001\n{part}\n[path]\nposes = {poses}\n");
        let world = world(&text);
        let grid = GridSpec::from_bounds([-1.0, -1.0, 1.0, 1.0], 0.1).unwrap();
        let map = true_map(&world, &world.scans(), &grid, 10.0);
        let mut want = vec![false; grid.cells()];
        let n = 2_000_000;
        for k in 0..n {
            let (s, c) = (std::f64::consts::TAU * span * (f64::from(k) + 0.5) / f64::from(n)).sin_cos();
            let at = |v: f64| ((v * 0.5001 + 1.0) / 0.1).floor() as usize;
            want[at(s) * grid.width + at(c)] = true;
        }
        let wrong = (0..grid.cells()).filter(|k| (map[*k] == 1) != want[*k]).count();
        assert_eq!(wrong, 0, "{free}, {span} of a circle");
    }
}

#[test]
fn nothing_is_known_without_a_scan() {
    let world = room(0.0, 0.0, "");
    let grid = GridSpec::from_bounds([0.0, 0.0, 5.0, 4.0], 0.1).unwrap();
    assert_eq!(count(&true_map(&world, &[], &grid, 5.0), 0), grid.cells());
}

#[test]
fn a_lasers_world_is_known_as_far_as_the_laser_sees() {
    use echogrid::evaluate::score::sensor_range;
    let shape = "[[outline]]\npoints = [[0,0],[12,0],[12,5],[0,5],[0,0]]\n[path]\nposes = [[1,1]]\n";
    let of = |rig: &str| sensor_range(&world(&format!("{shape}[rig]\nkind = \"{rig}\"\n")), None).unwrap();
    assert_eq!([of("dense"), of("ring8"), of("laser")], [5.0, 5.0, 13.0]);
    assert_eq!(sensor_range(&world(shape), Some(2.0)).unwrap(), 2.0);
}

#[test]
fn a_campus_keeps_the_files_classes() {
    let with = |more: &str| world(&format!("{more}[campus]\nwidth = 60\nheight = 40\n"));
    let classes = |w: &World| {
        let mut all: Vec<u16> = w.walls().iter().filter_map(|wall| wall.class).collect();
        all.sort_unstable();
        all.dedup();
        (w.classes.clone(), all)
    };
    let names = |n: &[&str]| n.iter().map(|s| s.to_string()).collect::<Vec<_>>();
    assert_eq!(classes(&with("")), (names(&["wall", "furniture"]), vec![1, 2]));
    let kiosk = "[[box]]\ncentre = [0.6, 0.6]\nsize = [0.5, 0.5]\nclass = \"kiosk\"\n";
    let (found, used) = classes(&with(kiosk));
    assert_eq!((found, used), (names(&["kiosk", "wall", "furniture"]), vec![1, 2, 3]));
    let kiosks = with(kiosk).walls().iter().filter(|w| w.class == Some(1)).count();
    assert_eq!(kiosks, 4);
}
