//! Completes the parameters of the counting sensor models from a log and a grid: class labels and the depth of an obstacle. It
//! checks that µm can tell the grid's cells apart.

use crate::grid::Palette;
use crate::log::classes::Classes;
use crate::method::settings::{Csm, Settings};
use crate::method::{Completed, LogFacts};
use crate::{Error, Result};

/// The largest edge of a cell, metres: a chunk's coordinates in µm must fit 32 bits.
const LARGEST_CELL: f64 = 2.0;

/// The largest distance of a grid's lower left corner from the origin, metres.
const FARTHEST_ORIGIN: f64 = 2e6;

/// Completes the parameters; see [`Method::complete`](crate::method::Method::complete).
pub(super) fn complete(mut csm: Csm, log: &LogFacts) -> Result<Completed> {
    let resolution = log.grid.resolution;
    if resolution > LARGEST_CELL {
        let what = format!("the counting sensor models take cells of at most {LARGEST_CELL} m, not {resolution} m");
        return Err(Error::Usage(what));
    }
    if !csm.continuous && csm.w_obstacle.is_none() {
        csm.w_obstacle = Some(2.0 * resolution);
    }
    let classes = if csm.semantic { Some(class_labels(log)?) } else { None };
    if let Some(classes) = &classes {
        csm.palette = classes.palette;
    }
    let origin = [log.grid.x0(), log.grid.y0()];
    if let Some(far) = origin.into_iter().find(|v| v.abs() > FARTHEST_ORIGIN) {
        return Err(Error::Usage(format!(
            "`bounds` begin at {far} m: the counting sensor models map up to {FARTHEST_ORIGIN:e} m from the origin"
        )));
    }
    Ok(Completed { settings: Settings::Csm(csm), classes })
}

/// The class labels: those of the user's file, or else those that the log names.
fn class_labels(log: &LogFacts) -> Result<Classes> {
    let names = log.class_names;
    let classes = match log.class_file {
        Some(file) => Some(Classes::open(file)?),
        None => Classes::named(names)
            .map(|named| Classes::rooms().ok().filter(|r| r.names[..r.count()] == *names).unwrap_or(named)),
    };
    let plain = "map it with csm-discrete or csm-continuous, which need none";
    match (classes, log.labelled) {
        (_, 0) => Err(Error::input(log.path, format!("none of its {} hits carries a class label: {plain}", log.hits))),
        (None, n) if names.is_empty() => Err(Error::input(
            log.path,
            format!(
                "{n} hits carry class labels, but nothing says what they are: name the classes with `classes`, or {plain}"
            ),
        )),
        (None, _) => {
            Err(Error::input(log.path, format!("{} classes, more than {}: {plain}", names.len(), Palette::MOST)))
        }
        (Some(classes), _) => Ok(classes),
    }
}
