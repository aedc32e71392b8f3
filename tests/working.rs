//! One reading explained: the numbers of the JSON, the colours of the picture, what is refused.

#![allow(clippy::unwrap_used, reason = "clippy.toml allows it in test functions; here are their helpers too")]

use echogrid::grid::{Data, GridSpec, Layer, Map, Scale};
use echogrid::log::reading::{Outcome, Pose, Reading, Record};
use echogrid::method::settings::Settings;
use echogrid::output::{WorkingRequest, write_working};
use echogrid::sensor::{AtMax, Kind, Sensor};
use echogrid::{Error, ErrorKind};
use serde_json::Value;

/// The colours behind the cone, and outside the grid.
const OCCUPIED: [u8; 3] = [90; 3];
const EMPTY: [u8; 3] = [250; 3];
const OUTSIDE: [u8; 3] = [150, 152, 158];

fn sensor(kind: Kind, r_min: f64, epsilon: f64) -> Sensor {
    let half_width = if kind == Kind::Laser { 0.0 } else { 15f64.to_radians() };
    let (id, epsilon) = ("s".into(), Some(epsilon));
    let (r_max, hit_range, no_echo_range) = (10.0, 10.0, 1.5);
    let at_r_max = AtMax::Hit;
    Sensor {
        id,
        kind,
        x: 0.0,
        y: 0.0,
        axis: 0.0,
        half_width,
        r_min,
        r_max,
        at_r_max,
        hit_range,
        no_echo_range,
        epsilon,
    }
}

fn reading(sensor: u32, x: f64, y: f64, degrees: f64, range: f64) -> Reading {
    let pose = Pose { x, y, heading: degrees.to_radians() };
    let record = Record { t: 2.5, scan: 3, sensor, robot: pose, pose, range, label: None, line: 17 };
    Reading { record, outcome: Outcome::Hit, range }
}

fn method(name: &str) -> Settings {
    Settings::of(name).unwrap()
}

/// Every cell unknown but those named.
fn map(grid: GridSpec, cells: &[(usize, usize, i8)]) -> Map {
    let mut class = vec![0i8; grid.cells()];
    cells.iter().for_each(|(c, r, v)| class[r * grid.width + c] = *v);
    let scale = Scale::Signed { limit: 1.0 };
    let layer = Layer { name: "class".into(), about: "", data: Data::I8(class), fill: 0.0, scale };
    Map { grid, method: "bayes".into(), layers: vec![layer], updates: 0, increments: Vec::new() }
}

/// What was written: the JSON, and the picture's pixels.
struct Written {
    json: Value,
    picture: image::RgbImage,
}

impl Written {
    fn of(
        grid: &GridSpec,
        sensors: &[Sensor],
        (readings, number): (&[Reading], usize),
        name: &str,
        map: Option<&Map>,
    ) -> Written {
        let folder = tempfile::tempdir().unwrap();
        let request = WorkingRequest { grid, sensors, readings, settings: &method(name), wedges: None, number, map };
        let paths = write_working(folder.path(), &request).unwrap();
        let names = paths.each_ref().map(|p| p.file_name().unwrap().to_string_lossy().into_owned());
        assert_eq!(names, [format!("working-{number}.png"), format!("working-{number}.json")]);
        let json = serde_json::from_slice(&std::fs::read(&paths[1]).unwrap()).unwrap();
        Written { json, picture: image::open(&paths[0]).unwrap().to_rgb8() }
    }

    fn cells(&self) -> &Vec<Value> {
        self.json["cells"].as_array().unwrap()
    }

    fn numbers(&self, region: &str, name: &str) -> Vec<f64> {
        self.cells().iter().filter(|c| c["region"] == region).map(|c| c[name].as_f64().unwrap()).collect()
    }

    /// A pixel within a cell of a panel, (¼, ¼) from the cell's lower left: off the lines through its middle.
    fn colour(&self, panel: usize, column: i64, row: i64) -> [u8; 3] {
        let layout = &self.json["picture"];
        let size = layout["pixels_per_cell"].as_f64().unwrap();
        let number = |v: &Value| v.as_i64().unwrap();
        let (c, r) = (column - number(&layout["first"][0]), row - number(&layout["first"][1]));
        let height = number(&layout["cells"][1]);
        let x = number(&layout["panels"][panel]["x"]) + ((c as f64 + 0.25) * size) as i64;
        let y = number(&layout["panels"][panel]["y"]) + ((height - r) as f64 * size - 0.25 * size) as i64;
        self.picture.get_pixel(x as u32, y as u32).0
    }
}

fn is_blue([r, g, b]: [u8; 3]) -> bool {
    b > r.saturating_add(25) && b > g
}

fn is_red([r, g, b]: [u8; 3]) -> bool {
    r > g.saturating_add(25) && r > b.saturating_add(25)
}

#[test]
fn the_specifications_vector_is_cancelled_and_normalised() {
    // A laser along a row whose arc holds cells at R − 2, −1, 0, 1 and 2 cells, ε two cells: Occ_k = (0, .75, 1, .75, 0).
    // Before it, beams up the last two columns left Emp = .5 and .8 there: 10 of 12 cells away, r_min chosen for it.
    let cell = 0.125;
    let grid = GridSpec::from_bounds([0.0, 0.0, 4.0, 4.0], cell).unwrap();
    let beam = |emp: f64| {
        let q = (1.0 - emp).sqrt();
        sensor(Kind::Laser, cell * (10.0 - 12.0 * q) / (1.0 - q), 2.0 * cell)
    };
    let sensors = [sensor(Kind::Laser, 0.05, 2.0 * cell), beam(0.5), beam(0.8)];
    let centre = |k: f64| (k + 0.5) * cell;
    let up = |sensor, column| reading(sensor, centre(column), centre(4.0), 90.0, 14.0 * cell);
    let readings = [up(1, 22.0), up(2, 23.0), reading(0, centre(2.0), centre(14.0), 0.0, 20.0 * cell)];
    let written = Written::of(&grid, &sensors, (&readings, 3), "certainty", None);
    let columns: Vec<u64> = written.numbers("arc", "column").iter().map(|c| *c as u64).collect();
    assert_eq!(columns, [20, 21, 22, 23, 24]);
    let near = |name: &str, want: [f64; 5]| {
        for (value, want) in written.numbers("arc", name).iter().zip(want) {
            assert!((value - want).abs() < 5e-8, "{name}: {value} is not {want}");
        }
    };
    near("own", [0.0, 0.75, 1.0, 0.75, 0.0]);
    near("cancelled", [0.0, 0.75, 0.5, 0.15, 0.0]);
    near("normalised", [0.0, 0.5357143, 0.3571429, 0.1071429, 0.0]);
    assert!((written.json["sum"].as_f64().unwrap() - 1.4).abs() < 1e-9);
    assert_eq!((written.json["interior_cells"].as_u64(), written.json["arc_cells"].as_u64()), (Some(18), Some(5)));
    // three panels one below the other; the cell that is cancelled most fades
    let faded: Vec<[u8; 3]> = (0..3).map(|panel| written.colour(panel, 23, 14)).collect();
    assert!(faded.iter().all(|c| is_red(*c)) && faded[0][1] < faded[1][1], "{faded:?}");
}

#[test]
fn a_reading_is_told_in_full() {
    let grid = GridSpec::from_bounds([0.0, 0.0, 4.0, 4.0], 0.1).unwrap();
    let sensors = [sensor(Kind::Sonar, 0.3, 0.1)];
    let mut silent = reading(0, 2.0, 2.0, 180.0, 1.5);
    (silent.outcome, silent.record.range) = (Outcome::NoEcho, f64::INFINITY);
    let readings = [reading(0, 0.5, 2.0, 0.0, 2.0), silent];
    let hit = Written::of(&grid, &sensors, (&readings, 1), "bayes", None).json;
    assert_eq!(hit["method"], "bayes");
    assert_eq!(hit["parameters"]["max_occ"], 0.98);
    let reading = &hit["reading"];
    assert_eq!((&reading["number"], &reading["line"], &reading["scan"]), (&1.into(), &17.into(), &3.into()));
    assert_eq!((&reading["sensor"], &reading["outcome"], &reading["z"]), (&"s".into(), &"hit".into(), &2.0.into()));
    assert_eq!(reading["pose"], serde_json::json!([0.5, 2.0, 0.0]));
    assert_eq!(hit["snapped"]["sensor"], serde_json::json!([160, 640]));
    assert_eq!(hit["snapped"]["reach"], serde_json::json!([608, 672]));
    assert_eq!(hit["snapped"]["axis"], serde_json::json!([8192, 0]));
    let silent = Written::of(&grid, &sensors, (&readings, 2), "dempster-shafer", None).json;
    assert_eq!((&silent["reading"]["z"], &silent["reading"]["outcome"]), (&Value::Null, &"no_echo".into()));
    assert_eq!((&silent["arc_cells"], silent["n"].as_u64() > Some(0)), (&0.into(), true));
}

#[test]
fn the_picture_stands_upright() {
    let grid = GridSpec::from_bounds([0.0, 0.0, 2.0, 2.0], 0.1).unwrap();
    let sensors = [sensor(Kind::Sonar, 0.3, 0.1)];
    // from the lower left to the upper right: 60 degrees
    let readings = [reading(0, 0.55, 0.45, 60.0, 1.0)];
    let behind = map(grid, &[(10, 5, 1), (4, 12, -1)]);
    for name in ["certainty", "dempster-shafer", "bayes", "himm"] {
        let written = Written::of(&grid, &sensors, (&readings, 1), name, Some(&behind));
        let (width, height) = written.picture.dimensions();
        assert!((600..=1200).contains(&width.max(height)), "{name}: {width} x {height}");
        for cell in written.cells() {
            let at = |key: &str| cell[key].as_i64().unwrap();
            let colour = written.colour(0, at("column"), at("row"));
            let line = colour[0] < 40 && colour[1] < 140; // an outline or the axis runs there
            let right = if cell["region"] == "arc" { is_red(colour) } else { is_blue(colour) };
            assert!(right || line, "{name}: {colour:?} in {cell}");
        }
        let arc = written.numbers("arc", "y");
        assert!(arc.iter().all(|y| *y > 1.0), "{name}: the arc lies above the sensor");
        assert_eq!((written.colour(0, 10, 5), written.colour(0, 4, 12)), (OCCUPIED, EMPTY), "{name}");
    }
}

#[test]
fn the_middle_of_a_cone_is_stronger_than_its_edge() {
    let grid = GridSpec::from_bounds([0.0, 0.0, 4.0, 4.0], 0.1).unwrap();
    let readings = [reading(0, 0.55, 2.05, 0.0, 3.0)];
    let written = Written::of(&grid, &[sensor(Kind::Sonar, 0.3, 0.1)], (&readings, 1), "bayes", None);
    let (near, edge) = (written.colour(0, 12, 20), written.colour(0, 30, 16));
    assert!(is_blue(near) && is_blue(edge) && near[0] + 60 < edge[0], "{near:?} {edge:?}");
}

#[test]
fn a_cone_beyond_the_grid_and_a_huge_one_are_drawn() {
    let grid = GridSpec::from_bounds([0.0, 0.0, 1.0, 1.0], 0.1).unwrap();
    let sensors = [sensor(Kind::Sonar, 0.3, 0.1)];
    let readings = [reading(0, 0.55, 0.55, 0.0, 2.0), reading(0, 30.0, 30.0, 0.0, 2.0)];
    let partly = Written::of(&grid, &sensors, (&readings, 1), "bayes", None);
    assert_eq!((partly.colour(0, 20, 5), partly.json["arc_cells"].as_u64()), (OUTSIDE, Some(0)));
    assert!(is_blue(partly.colour(0, 8, 5)));
    let away = Written::of(&grid, &sensors, (&readings, 2), "bayes", None);
    assert_eq!((away.cells().len(), away.colour(0, 310, 296)), (0, OUTSIDE));
    // 1500 cells: less than a pixel a cell
    let fine = GridSpec::from_bounds([0.0, -0.5, 4.0, 0.5], 0.002).unwrap();
    let narrow = [Sensor { half_width: 2f64.to_radians(), ..sensors[0].clone() }];
    let huge = Written::of(&fine, &narrow, (&[reading(0, 0.5, 0.0, 0.0, 3.0)], 1), "bayes", None);
    let (width, height) = huge.picture.dimensions();
    assert!(width <= 1201 && height < width && is_blue(huge.colour(0, 750, 258)), "{width} x {height}");
}

#[test]
fn what_can_not_be_shown_is_refused() {
    let grid = GridSpec::from_bounds([0.0, 0.0, 1.0, 1.0], 0.1).unwrap();
    let sensors = [sensor(Kind::Sonar, 0.3, 0.1)];
    let readings = [reading(0, 0.5, 0.5, 0.0, 0.4); 3];
    let folder = tempfile::tempdir().unwrap();
    let refused = |readings: &[Reading], number, map: Option<&Map>, folder: &std::path::Path| {
        let (grid, sensors, settings) = (&grid, &sensors, &method("bayes"));
        let request = WorkingRequest { grid, sensors, readings, settings, wedges: None, number, map };
        write_working(folder, &request).unwrap_err()
    };
    for number in [0, 4] {
        let error = refused(&readings, number, None, folder.path());
        assert!(
            matches!(&error, Error::Usage(text) if text.contains("3 readings") && text.contains("1 to 3")),
            "{error}"
        );
    }
    assert!(refused(&[], 1, None, folder.path()).to_string().contains("no reading"));
    let other = map(GridSpec { i0: 1, ..grid }, &[]);
    assert!(matches!(refused(&readings, 1, Some(&other), folder.path()), Error::Usage(_)));
    let missing = folder.path().join("missing");
    assert!(matches!(refused(&readings, 1, None, &missing), Error::Resources(_)));
    for x in [1e300, f64::NAN] {
        assert_eq!(refused(&[reading(0, x, 0.5, 0.0, 0.4)], 1, None, folder.path()).kind(), ErrorKind::Usage);
    }
    assert_eq!(refused(&[reading(7, 0.5, 0.5, 0.0, 0.4)], 1, None, folder.path()).kind(), ErrorKind::Usage);
}
