//! `api/working`: what the last item says of each cell that it changed, step by step.

use super::lane::Lane;
use crate::Result;
use crate::method::settings::Settings;
use crate::output::{own_is, weigher};
use crate::pipeline::step::{Cell, CellStory, explain};
use crate::view::protocol::{Working, WorkingStep, finite};

/// Largest number of cells in a response.
const MOST_CELLS: usize = 20_000;

/// What the last item says of each cell that it changed.
pub fn working(lane: &Lane) -> Result<Working> {
    let (stepper, settings) = (&lane.stepper, lane.stepper.method().settings());
    let explained = explain(stepper)?.unwrap_or_default();
    let has_steps = matches!(settings, Settings::Certainty(_));
    let arcs = explained.cells.iter().filter(|c| c.arc).count();
    let cells = &explained.cells[..explained.cells.len().min(MOST_CELLS)];
    let each = |of: &dyn Fn(&CellStory) -> Option<f64>| cells.iter().map(of).collect::<Vec<_>>();
    let evidence = |c: &CellStory, k: usize| c.evidence.and_then(|e| finite(e[k]));
    // Cancellation and normalisation are of the arc's evidence only.
    let step = |k: usize| has_steps.then(|| each(&|c| if c.arc { evidence(c, k) } else { None }));
    let strongest = cells.iter().map(|c| strength(&settings, c)).filter(|s| s.is_finite()).fold(0.0, f64::max);
    let shade = |c: &CellStory| finite(if strongest > 0.0 { strength(&settings, c) / strongest } else { 0.0 });
    let layers = lane.layer_names();
    let values = |of: &dyn Fn(&CellStory) -> &Cell| -> Vec<Vec<Option<f64>>> {
        (0..layers.len()).map(|k| each(&|c| finite(of(c).values[k].into()))).collect()
    };
    let (before, after) = (values(&|c| &c.before), values(&|c| &c.after));
    Ok(Working {
        position: stepper.position(),
        interior: explained.cells.len() - arcs,
        arc: arcs,
        n: arc_cells(&settings, explained.n, arcs),
        sum: explained.sum.and_then(finite),
        own_is: own_is(&settings),
        layers,
        steps: match has_steps {
            true => vec![WorkingStep::Own, WorkingStep::Cancelled, WorkingStep::Normalised],
            false => vec![WorkingStep::Own],
        },
        truncated: cells.len() < explained.cells.len(),
        column: cells.iter().map(|c| c.column).collect(),
        row: cells.iter().map(|c| c.row).collect(),
        region: cells.iter().map(|c| u8::from(c.arc)).collect(),
        d: each(&|c| finite(c.polar.0)),
        theta: each(&|c| finite(c.polar.1)),
        own: each(&|c| evidence(c, 0)),
        cancelled: step(1),
        normalised: step(2),
        strength: each(&shade),
        strongest: finite(strongest),
        strength_is: strength_is(&settings),
        before,
        after,
    })
}

/// n, the arc cells of a reading, where the method uses it: certainty for an echo, Dempster-Shafer for a missing one too.
fn arc_cells(settings: &Settings, n: usize, arcs: usize) -> Option<usize> {
    match settings {
        Settings::DempsterShafer(_) => Some(n),
        Settings::Certainty(_) => Some(n).filter(|_| arcs > 0),
        _ => None,
    }
}

/// How strong an item's evidence of a cell is; [`strength_is`] says what it is computed from.
fn strength(settings: &Settings, story: &CellStory) -> f64 {
    match story.evidence {
        Some(evidence) => weigher(settings)(evidence[0]),
        None => f64::from((story.after.combined - story.before.combined).abs()),
    }
}

fn strength_is(settings: &Settings) -> &'static str {
    match settings {
        Settings::Bayes(_) | Settings::Features(_) => "|2·own − 1|",
        Settings::Csm(_) => "how far the combined picture moved",
        _ => "own",
    }
}
