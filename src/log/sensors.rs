//! Completes a log's sensors: the description of the format or the log, overridden by the sensor file, overridden by `--set`.

use super::format::Source;
use super::mounting::{Beams, MountedSensor};
use super::options::Options;
use crate::sensor::{Description, Mounts, Overrides, SensorFile};
use crate::{Error, Result};
use std::path::Path;

/// The complete sensors of a log.
///
/// # Errors
/// An error names the last source whose values made the description inconsistent.
pub(super) fn complete(path: &Path, source: &dyn Source, options: &Options) -> Result<Vec<MountedSensor>> {
    let described = source.sensors();
    let file = options.sensor_file.as_deref().map(SensorFile::open).transpose()?;
    if let Some(file) = &file {
        check_file(file, described, source)?;
    }
    let set = options.overrides.description();
    let centred = options.overrides.mounts == Some(Mounts::None);
    let mut mounted = Vec::with_capacity(described.len());
    for (i, described) in described.iter().enumerate() {
        let mut description = described.clone();
        let header = |what: String| match source.sensor_line() {
            Some(line) => Error::at(path, line, what),
            None => Error::input(path, what),
        };
        let mut fault = description.complete(i).err().map(header);
        let over = file.as_ref().and_then(|f| f.sensors.get(i));
        if let (Some(over), Some(file)) = (over, &file) {
            description.merge(over);
            fault = description.complete(i).err().map(|what| fault.unwrap_or(Error::input(&file.path, what)));
        }
        description.merge(&set);
        override_beams(&mut description, &options.overrides, source)?;
        let sensor = description.complete(i).map_err(|what| fault.unwrap_or(Error::Usage(format!("--set: {what}"))));
        let mut sensor = sensor?;
        if centred {
            (sensor.x, sensor.y) = (0.0, 0.0);
        }
        let beams = match description {
            Description { beams: Some(count), first: Some(first), step: Some(step), .. } => {
                Some(Beams { count, first, step })
            }
            _ => None,
        };
        mounted.push(MountedSensor { sensor, beams, placed: over.is_some_and(Description::has_pose), centred });
    }
    Ok(mounted)
}

/// Applies `fov` and `first_beam` to a laser's beam layout; `fov` alone puts the beams evenly to both sides of the axis.
fn override_beams(description: &mut Description, set: &Overrides, source: &dyn Source) -> Result<()> {
    let (fov, first) = (set.fov, set.first_beam);
    if fov.is_none() && first.is_none() {
        return Ok(());
    }
    let Some(count) = description.beams.filter(|n| source.has_beams() && *n > 1) else {
        let what = "--set: fov and first_beam are for lasers whose beams the log doesn't lay out one by one; here each reading has \
                    its own heading";
        return Err(Error::Usage(what.into()));
    };
    if let Some(fov) = fov {
        let beams = Beams::over(fov, count);
        (description.first, description.step) = (Some(beams.first), Some(beams.step));
    }
    description.first = first.or(description.first);
    Ok(())
}

/// Checks that a sensor file fits the log.
fn check_file(file: &SensorFile, described: &[Description], source: &dyn Source) -> Result<()> {
    let (has, needs) = (file.sensors.len(), described.len());
    if has != needs {
        let names: Vec<&str> = described.iter().take(8).filter_map(|d| d.id.as_deref()).collect();
        let more = if needs > names.len() { ", …" } else { "" };
        let what = format!("describes {has} sensors, but the log has {needs} ({}{more})", names.join(", "));
        return Err(Error::input(&file.path, what));
    }
    for (over, under) in file.sensors.iter().zip(described) {
        let fail = |what: String| Err(Error::input(&file.path, what));
        let id = under.id.as_deref().unwrap_or("?");
        if (over.beams.is_some() || over.first.is_some() || over.step.is_some()) && !source.has_beams() {
            return fail("beams, first and step mean nothing for this log: each reading has its own heading".into());
        }
        if let (Some(a), Some(b)) = (over.beams, under.beams)
            && a != b
        {
            return fail(format!("sensor {id} has {a} beams here, but {b} in the log"));
        }
        if let (Some(a), Some(b)) = (over.kind, under.kind)
            && a != b
        {
            let name = |kind| if kind == crate::sensor::Kind::Sonar { "sonar" } else { "laser" };
            return fail(format!("sensor {id} is a {} here, but a {} in the log", name(a), name(b)));
        }
    }
    Ok(())
}
