//! One laser of a CARMEN log: the layout of its beams, its position, and the values that it writes for no return.

use super::message::{LaserLayout, ScanPose};
use crate::log::mounting::Beams;
use crate::log::no_return::{NoReturnCode, RangeHistogram};
use crate::log::reading::Pose;
use crate::sensor::{Description, Kind};

/// Ranges from here on are no return, metres: the limit of SICK's lasers, which nearly all of these logs come from.
pub(super) const MAX_RANGE: f64 = 80.0;
/// The share of readings of 0 from which the user is told.
const NOTED_ZEROS: f64 = 0.01;

/// One laser of the log: a layout of beams.
pub(super) struct CarmenLaser {
    pub layout: LaserLayout,
    /// Its name.
    pub id: String,
    pub beams: Beams,
    /// The source of their layout.
    pub origin: String,
    /// Its pose in the robot's frame, from its first message or the parameters.
    pub mount: Pose,
    pub first: ScanPose,
    pub ranges: RangeHistogram,
    /// Its messages, and those without a time stamp.
    pub messages: u64,
    pub timeless: u64,
    pub codes: Vec<NoReturnCode>,
    pub r_max: f64,
}

impl CarmenLaser {
    /// Its description.
    pub fn describe(&self) -> Description {
        Description {
            id: Some(self.id.clone()),
            kind: Some(Kind::Laser),
            x: Some(self.mount.x),
            y: Some(self.mount.y),
            axis: Some(self.mount.heading),
            r_max: Some(self.r_max),
            beams: Some(self.beams.count),
            first: Some(self.beams.first),
            step: Some(self.beams.step),
            ..Description::default()
        }
    }

    /// A note on the ranges that are read as no return.
    pub fn no_return_note(&self, declared: Option<f64>) -> Option<String> {
        let (count, most) = self.ranges.beyond(self.r_max);
        if count == 0 {
            return None;
        }
        let mut what = Vec::new();
        if !self.codes.is_empty() {
            let codes: Vec<String> = self.codes.iter().map(|c| format!("{} m ({})", c.range, c.count)).collect();
            what.push(format!("peaks at the end of its ranges are taken for no return: {}", codes.join(", ")));
        }
        if let Some(declared) = declared.filter(|d| *d <= self.r_max) {
            what.push(format!("the log declares a maximum of {declared} m"));
        }
        match declared {
            Some(declared) if declared > MAX_RANGE && self.r_max == MAX_RANGE => what.push(format!(
                "ranges from 80 m on are no return, though the log declares {declared} m: lasers of this kind write their codes there"
            )),
            _ if what.is_empty() => {
                what.push(format!("ranges from 80 m on are no return, most often {most} m"));
            }
            _ => {}
        }
        (!what.is_empty()).then(|| {
            let (id, what, r_max) = (&self.id, what.join("; "), self.r_max);
            format!("{id}: {what}. So its r_max is {r_max} m, which {count} readings reach; --set r_max=… decides otherwise.")
        })
    }

    pub fn zeros_note(&self) -> Option<String> {
        let (all, none) = (self.ranges.all, self.ranges.none);
        (none as f64 > NOTED_ZEROS * all as f64).then(|| {
            let id = &self.id;
            format!(
                "{id}: {none} of {all} readings are 0 or less, which may be a missing return or a fault: they are rejected and free \
                 nothing."
            )
        })
    }
}
