//! The columns of a table, from the text of `--columns`: names with units, separated by commas.

use crate::log::values::quote;
use crate::support::suggest::similar;
use std::fmt;

/// The content of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ColumnRole {
    Skip,
    T,
    Scan,
    Sensor,
    /// The robot's pose.
    Px,
    Py,
    Ph,
    /// The sensor's pose.
    X,
    Y,
    H,
    Range,
    /// A reading's bearing from its sensor's axis.
    Angle,
    Label,
}

/// The names of columns, the preferred one of each first.
const NAMES: &[(&str, ColumnRole)] = &[
    ("t", ColumnRole::T),
    ("time", ColumnRole::T),
    ("x", ColumnRole::X),
    ("y", ColumnRole::Y),
    ("heading", ColumnRole::H),
    ("theta", ColumnRole::H),
    ("yaw", ColumnRole::H),
    ("h", ColumnRole::H),
    ("px", ColumnRole::Px),
    ("py", ColumnRole::Py),
    ("ph", ColumnRole::Ph),
    ("range", ColumnRole::Range),
    ("ranges", ColumnRole::Range),
    ("z", ColumnRole::Range),
    ("angle", ColumnRole::Angle),
    ("angles", ColumnRole::Angle),
    ("bearing", ColumnRole::Angle),
    ("sensor", ColumnRole::Sensor),
    ("scan", ColumnRole::Scan),
    ("label", ColumnRole::Label),
    ("-", ColumnRole::Skip),
    ("_", ColumnRole::Skip),
];

/// A column, and the factor from its unit to metres, radians or seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Column {
    pub role: ColumnRole,
    pub scale: f64,
}

/// The columns of a table with their repetitions; `None`: repeated to the end of the row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Columns {
    items: Vec<(Column, Option<usize>)>,
    text: String,
}

impl fmt::Display for Columns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Columns {
    /// Parses the text of `--columns`.
    ///
    /// # Errors
    /// A text that names the column at fault.
    pub fn parse(text: &str) -> Result<Columns, String> {
        let mut items = Vec::new();
        for item in text.split(',').map(str::trim) {
            let wrong = |what: String| format!("{}: {what}", quote(item));
            let (item_, rest) = match item.strip_suffix("...").or_else(|| item.strip_suffix('…')) {
                Some(item) => (item, true),
                None => (item, false),
            };
            // A unit may stand before or behind the count: range:mm*8, range*8:mm.
            let (mut name, mut unit, mut count) = (item_, None, None);
            for _ in 0..2 {
                match name.rfind([':', '*']) {
                    Some(at) if name[at..].starts_with(':') && unit.is_none() => {
                        (name, unit) = (&name[..at], Some(&name[at + 1..]));
                    }
                    Some(at) if name[at..].starts_with('*') && count.is_none() => {
                        let number = name[at + 1..].trim().parse::<usize>().ok().filter(|n| (1..=100_000).contains(n));
                        count = Some(
                            number.ok_or_else(|| wrong("a count is a whole number from 1, as in range*180".into()))?,
                        );
                        name = &name[..at];
                    }
                    _ => {}
                }
            }
            let known: Vec<&str> = NAMES.iter().map(|(name, _)| *name).collect();
            let lower = name.trim().to_ascii_lowercase();
            let role = NAMES.iter().find(|(name, _)| *name == lower).map(|(_, role)| *role);
            let role = role.ok_or_else(|| wrong(format!("no such column{}", similar(&lower, &known))))?;
            let scale = unit.map_or(Ok(1.0), |unit| scale(role, unit.trim())).map_err(wrong)?;
            if rest && count.is_some() {
                return Err(wrong("either a count or …, not both".into()));
            }
            items.push((Column { role, scale }, if rest { None } else { Some(count.unwrap_or(1)) }));
        }
        if items.iter().filter(|(_, count)| count.is_none()).count() > 1 {
            return Err("… can be given once: how many columns each of two has isn't known".into());
        }
        // x, y and heading are the robot's, unless px, py and ph are.
        let has = |items: &[(Column, Option<usize>)], role| items.iter().any(|(c, _)| c.role == role);
        let robots =
            [(ColumnRole::X, ColumnRole::Px), (ColumnRole::Y, ColumnRole::Py), (ColumnRole::H, ColumnRole::Ph)];
        if !has(&items, ColumnRole::Px) && !has(&items, ColumnRole::Py) && !has(&items, ColumnRole::Ph) {
            for (column, _) in &mut items {
                if let Some((_, robot)) = robots.iter().find(|(own, _)| *own == column.role) {
                    column.role = *robot;
                }
            }
        } else if !has(&items, ColumnRole::Ph) && !has(&items, ColumnRole::X) {
            for (column, _) in items.iter_mut().filter(|(column, _)| column.role == ColumnRole::H) {
                column.role = ColumnRole::Ph;
            }
        }
        let columns = Columns { items, text: text.into() };
        columns.check()?;
        Ok(columns)
    }

    fn check(&self) -> Result<(), String> {
        for (role, name) in [
            (ColumnRole::T, "t"),
            (ColumnRole::Scan, "scan"),
            (ColumnRole::Sensor, "sensor"),
            (ColumnRole::Px, "x (the robot's)"),
            (ColumnRole::Py, "y (the robot's)"),
            (ColumnRole::Ph, "heading (the robot's)"),
            (ColumnRole::X, "x (the sensor's)"),
            (ColumnRole::Y, "y (the sensor's)"),
            (ColumnRole::H, "heading (the sensor's)"),
            (ColumnRole::Label, "label"),
        ] {
            if self.items.iter().filter(|(c, _)| c.role == role).map(|(_, n)| n.unwrap_or(2)).sum::<usize>() > 1 {
                return Err(format!("two columns are {name}"));
            }
        }
        let robot = [ColumnRole::Px, ColumnRole::Py, ColumnRole::Ph].map(|role| self.has(role));
        if robot.contains(&true) && robot.contains(&false) {
            return Err("the robot's pose is x, y and heading: name all three, or none and give --poses".into());
        }
        let sensor = [ColumnRole::X, ColumnRole::Y, ColumnRole::H].map(|role| self.has(role));
        if sensor.contains(&true) && sensor.contains(&false) {
            return Err("the sensor's pose is x, y and h beside px, py and ph: name all three or none".into());
        }
        Ok(())
    }

    /// Whether a column has this role.
    pub fn has(&self, role: ColumnRole) -> bool {
        self.items.iter().any(|(c, _)| c.role == role)
    }

    /// Checks that the columns make readings.
    ///
    /// # Errors
    /// A text that names the missing column.
    pub fn gives_readings(&self) -> Result<(), String> {
        match (self.has(ColumnRole::Range), self.has(ColumnRole::Px), self.has(ColumnRole::T)) {
            (false, ..) => Err("no column is called range".into()),
            (true, false, false) => Err("without x, y and heading it needs t: --poses takes poses by time".into()),
            _ => Ok(()),
        }
    }

    /// Checks that the columns make poses with times.
    ///
    /// # Errors
    /// A text that names the columns of poses.
    pub fn gives_poses(&self) -> Result<(), String> {
        match self.has(ColumnRole::Px) && self.has(ColumnRole::T) {
            true => Ok(()),
            false => Err("poses are t, x, y and heading".into()),
        }
    }

    /// The columns of a row of `cells` cells.
    ///
    /// # Errors
    /// A text that says how many cells were expected.
    pub fn of(&self, cells: usize) -> Result<Vec<Column>, String> {
        let fixed: usize = self.items.iter().filter_map(|(_, count)| *count).sum();
        let open = self.items.iter().any(|(_, count)| count.is_none());
        if fixed > cells || (fixed < cells && !open) || (open && fixed == cells) {
            let more = if open { "more than " } else { "" };
            return Err(format!("expected {more}{fixed} cells, as --columns says, found {cells}"));
        }
        let repeat = |(column, count): &(Column, Option<usize>)| vec![*column; count.unwrap_or(cells - fixed)];
        let columns: Vec<Column> = self.items.iter().flat_map(repeat).collect();
        let count = |role| columns.iter().filter(|c| c.role == role).count();
        match (count(ColumnRole::Range), count(ColumnRole::Angle)) {
            (ranges, angles) if angles != 0 && angles != ranges => {
                Err(format!("{ranges} ranges, but {angles} angles: each range wants its own, or none has one"))
            }
            _ => Ok(columns),
        }
    }
}

/// The factor from a unit to metres, radians or seconds. Angles with a minus sign are clockwise.
///
/// # Errors
/// A text that lists the units of such a column.
pub(crate) fn scale(role: ColumnRole, unit: &str) -> Result<f64, String> {
    let units: &[(&str, f64)] = match role {
        ColumnRole::T => &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)],
        ColumnRole::Px | ColumnRole::Py | ColumnRole::X | ColumnRole::Y | ColumnRole::Range => {
            &[("m", 1.0), ("cm", 1e-2), ("mm", 1e-3)]
        }
        ColumnRole::Ph | ColumnRole::H | ColumnRole::Angle => &[
            ("rad", 1.0),
            ("deg", std::f64::consts::PI / 180.0),
            ("-rad", -1.0),
            ("-deg", -std::f64::consts::PI / 180.0),
        ],
        ColumnRole::Skip | ColumnRole::Scan | ColumnRole::Sensor | ColumnRole::Label => {
            return Err("it has no unit".into());
        }
    };
    units.iter().find(|(name, _)| *name == unit).map(|(_, scale)| *scale).ok_or_else(|| {
        let names: Vec<&str> = units.iter().map(|(name, _)| *name).collect();
        format!("its unit is one of {}", names.join(", "))
    })
}
