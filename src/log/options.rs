//! How a log is to be read: which sensors, which columns or variables, whose poses.

use crate::sensor::{Kind, Overrides};
use std::path::PathBuf;

/// How to read a log.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Only sensors of this kind; `None`: the kind that the log holds (sonar, if a folder holds both).
    pub kind: Option<Kind>,
    /// A sensor file, which overrides the log's own description of its sensors.
    pub sensor_file: Option<PathBuf>,
    /// Parameters of every sensor, which override all else.
    pub overrides: Overrides,
    /// The columns of a plain table, such as `t,x,y,heading:deg,range:cm` (docs/formats.md); the log is read as one.
    pub columns: Option<String>,
    /// The variables of a MATLAB or Octave file, such as `pose=P,ranges=R,angles=A` (docs/formats.md).
    pub fields: Option<String>,
    /// A file of the robot's poses by time, in place of the log's.
    pub poses: Option<PathBuf>,
    /// The columns of a table of poses, such as `t,x,y,heading`.
    pub pose_columns: Option<String>,
    /// A classes file: names and colours of the labels, in place of the log's.
    pub classes: Option<PathBuf>,
    /// Folder for the copy of a stream; `None`: the system's temporary folder.
    pub spool: Option<PathBuf>,
}

impl Options {
    /// The options that name columns, variables and poses, with their texts.
    pub(super) fn mapping(&self) -> Vec<(&'static str, String)> {
        let poses = self.poses.as_ref().map(|path| path.display().to_string());
        [("columns", &self.columns), ("fields", &self.fields), ("poses", &poses), ("pose_columns", &self.pose_columns)]
            .into_iter()
            .filter_map(|(name, text)| Some((name, text.clone()?)))
            .collect()
    }
}
