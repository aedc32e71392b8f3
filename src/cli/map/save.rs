//! Saving a map that was made in memory, and what a report says of its run.

use crate::Result;
use crate::feature;
use crate::kernels::Chosen;
use crate::log::reading::Counts;
use crate::output::{self, Folder, LogInfo, Report, RunInfo};
use crate::pipeline::session::{MappedLog, Session};

/// The backend that made a map.
#[derive(Debug, Clone, Default)]
pub struct BackendUsed {
    /// oracle, cpu or gpu.
    pub backend: &'static str,
    /// The adapter or processor; `None` for the oracle.
    pub adapter: Option<String>,
    /// Why it was chosen; empty where the user chose it.
    pub why: String,
}

impl BackendUsed {
    /// Names a chosen backend.
    pub fn of(chosen: &Chosen) -> BackendUsed {
        BackendUsed { backend: chosen.backend.name(), adapter: Some(chosen.backend.adapter()), why: chosen.why.clone() }
    }
}

/// A map to save, made with all chunks in memory.
pub struct FinishedRun<'a> {
    /// The log.
    pub session: &'a Session,
    /// Its map.
    pub mapped: &'a MappedLog,
    /// What made it.
    pub backend: &'a BackendUsed,
    /// The stages and their seconds.
    pub seconds: Vec<(String, f64)>,
    /// Whether to write every layer as .npy.
    pub npy: bool,
}

/// Writes the files of a map, and returns its report.
///
/// # Errors
/// [`crate::Error::Resources`] if a file can't be written.
pub fn save(folder: &Folder, run: FinishedRun) -> Result<Report> {
    let FinishedRun { session, mapped, backend, seconds, npy } = run;
    let features = mapped.features.as_ref().map(feature::StageResult::summary);
    let info = RunInfo { features, ..run_info(session, backend, mapped.counts, seconds)? };
    let report = output::write_map(folder, &mapped.finished.map, &mapped.finished.combined, &info, npy)?;
    if let Some(found) = &mapped.features {
        output::write_features(folder.path(), &found.feature_map, &session.grid)?;
    }
    Ok(report)
}

/// The information about a run that its report holds.
pub(super) fn run_info(
    session: &Session,
    used: &BackendUsed,
    counts: Counts,
    seconds: Vec<(String, f64)>,
) -> Result<RunInfo> {
    Ok(RunInfo {
        parameters: output::parameters(session.parameters()),
        log: LogInfo {
            path: session.log.path().display().to_string(),
            sha256: session.log.sha256()?,
            beams: session.log.beams(),
            notes: session.notes(),
        },
        sensors: session.sensors().to_vec(),
        readings: counts,
        seconds,
        busy: Vec::new(),
        backend: used.backend.into(),
        adapter: used.adapter.clone(),
        bad_lines: session.survey.bad_lines.clone(),
        classes: session.classes.as_ref().map_or_else(Vec::new, |c| c.names.clone()),
        features: None,
    })
}
