//! What a user should know of how a log is read: the layout of its beams, values taken for no return, and notes of its files.

use super::input::Input;
use super::log_file::Log;

impl Log {
    /// The beam layouts of its lasers and their sources, as sentences.
    pub fn beams(&self) -> Vec<String> {
        self.layouts().into_iter().map(|layout| layout.0).collect()
    }

    /// The same, each with whether it is certain.
    fn layouts(&self) -> Vec<(String, bool)> {
        let mut layouts = Vec::new();
        for (i, (mounted, described)) in self.sensors.iter().zip(self.source.sensors()).enumerate() {
            let (Some(beams), Some((origin, plain))) = (mounted.beams, self.source.beams_origin(i)) else { continue };
            let own = described.first == Some(beams.first) && described.step == Some(beams.step);
            let origin = if own { origin } else { "--set or the sensor file".into() };
            // Rounded to what a user would write.
            let degrees = |angle: f64| (angle.to_degrees() * 1e4).round() / 1e4;
            let (id, count, first, step) = (&mounted.sensor.id, beams.count, degrees(beams.first), degrees(beams.step));
            let span = degrees(beams.step * f64::from(count.saturating_sub(1)));
            let text = format!("{id}: {count} beams over {span}°, {step}° apart, the first at {first}°, by {origin}.");
            layouts.push((text, plain && own));
        }
        layouts
    }

    /// Notes for the user on how the log is read, as sentences; complete after the first pass.
    pub fn notes(&self) -> Vec<String> {
        let mut notes: Vec<String> = self.layouts().into_iter().filter(|(_, plain)| !plain).map(|l| l.0).collect();
        // A value of the user's overrides the log's.
        let own =
            self.sensors.iter().zip(self.source.sensors()).map(|(m, d)| d.r_max.is_none_or(|r| r == m.sensor.r_max));
        notes.extend(own.enumerate().filter(|(_, own)| *own).filter_map(|(i, _)| self.source.no_return_note(i)));
        notes.extend(self.source.notes());
        let inputs = self.source.inputs();
        let of = |input: &&Input| -> Vec<String> {
            let name = input.path().file_name().unwrap_or_default().display();
            let whose = if inputs.len() > 1 { format!("{name}: ") } else { String::new() };
            input.notes().into_iter().map(|note| format!("{whose}{note}")).collect()
        };
        notes.extend(inputs.iter().flat_map(of));
        notes
    }
}
