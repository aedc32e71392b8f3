//! A session's parameters, as they are listed.

use super::Session;
use crate::sensor::Sensor;

impl Session {
    /// The sensors' parameters and the method's, as the report lists them: one value where all sensors agree, else all of them.
    pub fn parameters(&self) -> Vec<(String, String)> {
        let resolution = self.grid.resolution;
        let sensors = self.sensors();
        let numbers = |s: &Sensor| {
            [
                ("beta", s.half_width),
                ("r_min", s.r_min),
                ("r_max", s.r_max),
                ("hit_range", s.hit_range),
                ("no_echo_range", s.no_echo_range),
                ("epsilon", s.epsilon(resolution)),
            ]
        };
        let mut all = vec![("resolution".to_string(), resolution.to_string())];
        for (k, (name, first)) in sensors.first().map(numbers).into_iter().flatten().enumerate() {
            let values: Vec<String> = sensors.iter().map(|s| numbers(s)[k].1.to_string()).collect();
            let one = values.iter().all(|v| *v == first.to_string());
            all.push((name.into(), if one { first.to_string() } else { values.join(" ") }));
        }
        all.push(("mounts".into(), self.log.mounts().into()));
        all.extend(self.log.mapping().iter().map(|(name, text)| (name.to_string(), text.clone())));
        all.extend(self.method.settings().values().into_iter().map(|(k, v)| (k.to_string(), v)));
        all
    }
}
