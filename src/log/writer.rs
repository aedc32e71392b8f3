//! Writes echogrid's own log as JSON Lines. Numbers are written so that they read back to the bit.

use crate::log::reading::Record;
use crate::sensor::Sensor;
use crate::{Error, Result};
use serde::Serialize;
use std::io::Write;

#[derive(Serialize)]
struct Header<'a> {
    echogrid_log: u32,
    sensors: Vec<SensorLine<'a>>,
    classes: &'a [String],
}

#[derive(Serialize)]
struct SensorLine<'a> {
    id: &'a str,
    kind: crate::sensor::Kind,
    x: f64,
    y: f64,
    axis: f64,
    half_width: f64,
    r_min: f64,
    r_max: f64,
    at_r_max: crate::sensor::AtMax,
    hit_range: f64,
    no_echo_range: f64,
    epsilon: Option<f64>,
}

#[derive(Serialize)]
struct Line {
    t: f64,
    scan: u64,
    sensor: u32,
    px: f64,
    py: f64,
    ph: f64,
    x: f64,
    y: f64,
    h: f64,
    z: Range,
    #[serde(skip_serializing_if = "Option::is_none")]
    label: Option<u16>,
}

/// A range as JSON can write it.
#[derive(Serialize)]
#[serde(untagged)]
enum Range {
    Metres(f64),
    NoEcho(()),
    Broken(&'static str),
}

/// A log being written.
pub struct Writer<W: Write> {
    out: W,
    records: u64,
}

impl<W: Write> Writer<W> {
    /// Begins a log with its header.
    ///
    /// # Errors
    /// [`Error::Resources`] if it can't be written.
    pub fn new(mut out: W, sensors: &[Sensor], classes: &[String]) -> Result<Self> {
        let sensors = sensors.iter().map(|s| SensorLine {
            id: &s.id,
            kind: s.kind,
            x: s.x,
            y: s.y,
            axis: s.axis,
            half_width: s.half_width,
            r_min: s.r_min,
            r_max: s.r_max,
            at_r_max: s.at_r_max,
            hit_range: s.hit_range,
            no_echo_range: s.no_echo_range,
            epsilon: s.epsilon,
        });
        line(&mut out, &Header { echogrid_log: 1, sensors: sensors.collect(), classes })?;
        Ok(Writer { out, records: 0 })
    }

    /// Writes one record. Its line number is not kept: it gets a new one.
    ///
    /// # Errors
    /// [`Error::Resources`] if it can't be written.
    pub fn write(&mut self, record: &Record) -> Result<()> {
        let z = match record.range {
            z if z.is_finite() => Range::Metres(z),
            z if z.is_nan() => Range::Broken("NaN"),
            z if z < 0.0 => Range::Broken("-inf"),
            _ => Range::NoEcho(()),
        };
        self.records += 1;
        line(
            &mut self.out,
            &Line {
                t: record.t,
                scan: record.scan,
                sensor: record.sensor,
                px: record.robot.x,
                py: record.robot.y,
                ph: record.robot.heading,
                x: record.pose.x,
                y: record.pose.y,
                h: record.pose.heading,
                z,
                label: record.label,
            },
        )
    }

    /// How many records were written.
    pub fn records(&self) -> u64 {
        self.records
    }

    /// Ends the log and gives the writer back, flushed.
    ///
    /// # Errors
    /// [`Error::Resources`] if the rest can't be written.
    pub fn finish(mut self) -> Result<W> {
        self.out.flush().map_err(full)?;
        Ok(self.out)
    }
}

fn line(out: &mut impl Write, value: &impl Serialize) -> Result<()> {
    serde_json::to_writer(&mut *out, value).map_err(|e| full(e.into()))?;
    out.write_all(b"\n").map_err(full)
}

fn full(error: std::io::Error) -> Error {
    Error::Resources(format!("the log can't be written: {error}"))
}
