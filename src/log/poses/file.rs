//! A file of poses by time, read through.

use crate::log::cells::split_cells;
use crate::log::input::Input;
use crate::log::reading::Pose;
use crate::log::rostopic::row::TopicLayout;
use crate::log::table::columns::Columns;
use crate::log::table::separator::Separator;
use crate::log::table::suggest;
use crate::log::text::for_each_line;
use crate::log::track::yaw;
use crate::log::values::{check_pose, parse_real, quote};
use crate::{Error, Result};

/// Times beyond this are nanoseconds, not seconds.
const NANOSECONDS: f64 = 1e17;

/// The format of a file of poses.
enum PoseFormat {
    Topic(TopicLayout),
    /// t x y z and a quaternion; counts the quaternions that tip the robot over.
    Tum(u64),
    Columns(Columns, Separator),
}

/// Poses with their times, seconds, and notes for the user.
pub(super) type PosesAndNotes = (Vec<(f64, Pose)>, Vec<String>);

/// Reads all poses of a file.
///
/// # Errors
/// [`Error::Input`] if the file holds no pose, or its columns are unknown.
pub(super) fn read_poses(input: &Input, columns: Option<&str>) -> Result<PosesAndNotes> {
    let mut poses = Vec::new();
    let (mut bad, mut first_bad) = (0u64, String::new());
    let mut format: Option<PoseFormat> = None;
    let mut fault = None;
    let mut notes = Vec::new();
    for_each_line(input, |line, number| {
        let text = line.trim();
        if text.is_empty() || text.starts_with('#') {
            return true;
        }
        if format.is_none() {
            match detect(text, columns) {
                Ok((found, named)) => {
                    let header = match &found {
                        PoseFormat::Topic(layout) => layout.header,
                        PoseFormat::Tum(_) => false,
                        PoseFormat::Columns(..) => named,
                    };
                    if let (PoseFormat::Columns(columns, _), None) = (&found, columns) {
                        notes.push(format!("its columns are taken to be {columns} (--pose-columns says otherwise)"));
                    }
                    format = Some(found);
                    if header {
                        return true;
                    }
                }
                Err(what) => {
                    fault = Some(Error::at(input.path(), number, what));
                    return false;
                }
            }
        }
        let Some(format) = &mut format else { return true };
        match pose(format, text).and_then(|(t, pose)| check_pose("the robot's", &pose).map(|()| (t, pose))) {
            Ok(found) => poses.push(found),
            Err(what) => {
                bad += 1;
                if first_bad.is_empty() {
                    first_bad = format!("line {number}: {what}");
                }
            }
        }
        true
    })?;
    if let Some(error) = fault {
        return Err(error);
    }
    if poses.is_empty() {
        let what = if bad > 0 { format!("holds no pose: {first_bad}") } else { "holds no pose".into() };
        return Err(Error::input(input.path(), what));
    }
    if let Some(PoseFormat::Tum(tipped)) = format
        && 4 * tipped > poses.len() as u64
    {
        notes.push(format!(
            "{tipped} of its {} quaternions tip the robot over: TUM's order is qx qy qz qw; where w stands first, move it to the end",
            poses.len()
        ));
    }
    let name = input.path().display();
    let mut all: Vec<String> = notes.into_iter().map(|note| format!("{name}: {note}")).collect();
    if bad > 0 {
        all.push(format!("{name}: {bad} lines are no poses and were left out; the first is {first_bad}"));
    }
    Ok((poses, all))
}

/// The format of a file by its first line, and whether this line holds names.
fn detect(line: &str, columns: Option<&str>) -> std::result::Result<(PoseFormat, bool), String> {
    if let Some(spec) = columns {
        let columns = Columns::parse(spec)?;
        columns.gives_poses()?;
        let rows = Separator::of(line);
        let named = rows.is_header(line, &columns);
        return Ok((PoseFormat::Columns(columns, rows), named));
    }
    if let Some(layout) = TopicLayout::of(line) {
        return match layout.pose(&[]) {
            Some(_) => Ok((PoseFormat::Topic(layout), false)),
            None => Err("is a topic of readings, not of poses: record the robot's poses (such as /odom) too".into()),
        };
    }
    let rows = Separator::of(line);
    let cells = rows.split(line);
    let named = cells.iter().any(|cell| parse_real(cell).is_none());
    let spec = match (named, cells.len()) {
        (false, 8) => return Ok((PoseFormat::Tum(0), false)),
        (false, 4) => "t,x,y,heading".to_string(),
        (true, _) => suggest::columns_for(&cells),
        (false, n) => {
            return Err(format!(
                "{n} columns: what they are isn't known; name them with --pose-columns, such as t,x,y,heading:deg"
            ));
        }
    };
    match Columns::parse(&spec).and_then(|columns| columns.gives_poses().map(|()| columns)) {
        Ok(columns) => Ok((PoseFormat::Columns(columns, rows), named)),
        Err(_) => Err(format!(
            "{} is no row of poses that is known; name its columns: --pose-columns {spec} (it needs t, x, y and heading)",
            quote(line)
        )),
    }
}

fn pose(format: &mut PoseFormat, line: &str) -> std::result::Result<(f64, Pose), String> {
    match format {
        PoseFormat::Topic(layout) => {
            let cells = split_cells(line, b',');
            let pose = layout.pose(&cells).ok_or("no pose")??;
            Ok((layout.time(&cells)?, pose))
        }
        PoseFormat::Tum(tipped) => {
            let cells = line.split(|c: char| c == ',' || c.is_whitespace()).filter(|cell| !cell.is_empty());
            let values: Option<Vec<f64>> = cells.map(parse_real).collect();
            match values.as_deref() {
                Some([t, x, y, _, qx, qy, qz, qw]) if t.is_finite() => {
                    *tipped += u64::from(qx * qx + qy * qy > qz * qz + qw * qw);
                    let seconds = if *t > NANOSECONDS { t / 1e9 } else { *t };
                    Ok((seconds, Pose { x: *x, y: *y, heading: yaw(*qx, *qy, *qz, *qw) }))
                }
                _ => Err("expected t x y z qx qy qz qw".into()),
            }
        }
        PoseFormat::Columns(columns, rows) => rows.pose(line, columns),
    }
}
