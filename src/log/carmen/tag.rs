//! The names of CARMEN's laser messages.

use std::fmt;

/// Messages of one form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Family {
    /// `FLASER`, `RLASER`: ranges, a pose and the odometry's.
    Flat,
    /// `ROBOTLASER1` and on: with the layout of the beams, the laser's pose and the robot's.
    Robot,
    /// `RAWLASER1` and on: with the layout of the beams, without a pose.
    Raw,
    /// `LASER1` and on: ranges alone.
    Bare,
    /// `LASER_READING`: ranges and a pose.
    Reading,
}

/// A laser's message: which form, which laser.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Tag {
    pub family: Family,
    /// 1 is in front, 2 behind, looking backwards; the others are anywhere.
    pub laser: u8,
}

impl Tag {
    /// From a line's first word, in capitals or not.
    pub fn of(word: &str) -> Option<Tag> {
        let word = word.to_ascii_uppercase();
        let tag = |family, laser| Some(Tag { family, laser });
        match word.as_str() {
            "FLASER" => return tag(Family::Flat, 1),
            "RLASER" => return tag(Family::Flat, 2),
            "LASER_READING" => return tag(Family::Reading, 1),
            _ => {}
        }
        let (name, digit) = word.split_at_checked(word.len().checked_sub(1)?)?;
        let laser = digit.parse().ok().filter(|n| *n > 0)?;
        match name {
            "ROBOTLASER" => tag(Family::Robot, laser),
            "RAWLASER" => tag(Family::Raw, laser),
            "LASER" => tag(Family::Bare, laser),
            _ => None,
        }
    }

    /// Whether its position on the robot is known by convention.
    pub fn mounted(self) -> bool {
        self.laser <= 2
    }

    /// Whether it is the rear laser.
    pub fn rear(self) -> bool {
        self.laser == 2
    }
}

impl fmt::Display for Tag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.family, self.laser) {
            (Family::Flat, 1) => f.write_str("FLASER"),
            (Family::Flat, _) => f.write_str("RLASER"),
            (Family::Reading, _) => f.write_str("LASER_READING"),
            (Family::Robot, n) => write!(f, "ROBOTLASER{n}"),
            (Family::Raw, n) => write!(f, "RAWLASER{n}"),
            (Family::Bare, n) => write!(f, "LASER{n}"),
        }
    }
}
