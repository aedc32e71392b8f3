//! "Did you mean …?": the known name closest to an unknown one, by the names that other programs use (`synonyms`), else by
//! spelling.

mod synonyms;

use synonyms::SYNONYMS;

/// The least Jaro-Winkler similarity of a suggestion.
const MIN_SIMILARITY: f64 = 0.8;
/// The fewest letters of a name suggested by its spelling: shorter ones are similar to too many words.
const MIN_LETTERS: usize = 3;

/// The end of a message about an unknown name: "; did you mean …?", or the list of the known names.
pub(crate) fn similar(name: &str, known: &[&str]) -> String {
    match closest(name, known) {
        Some(name) => format!("; did you mean {name}?"),
        None => format!("; known are {}", known.join(", ")),
    }
}

/// The known name closest to `name`, in quotes and with a remark where its meaning differs; `None` where no known name is close.
pub(crate) fn closest(name: &str, known: &[&str]) -> Option<String> {
    let normalised = normalised(name);
    if let Some(same) = known.iter().find(|k| self::normalised(k) == normalised) {
        return Some(format!("{same:?}"));
    }
    let synonym =
        SYNONYMS.iter().filter(|(words, ..)| words.contains(&normalised.as_str())).find_map(|(_, names, remark)| {
            let here: Vec<String> =
                names.iter().filter(|n| known.contains(n)).take(2).map(|n| format!("{n:?}")).collect();
            let remark = if remark.is_empty() { String::new() } else { format!(" ({remark})") };
            (!here.is_empty()).then(|| here.join(" or ") + &remark)
        });
    synonym.or_else(|| nearest(&normalised, known).map(|near| format!("{near:?}")))
}

/// The known name with the most similar spelling, if it is similar enough.
fn nearest<'a>(normalised: &str, known: &[&'a str]) -> Option<&'a str> {
    let near = |k: &str| strsim::jaro_winkler(normalised, &self::normalised(k));
    let known = known.iter().filter(|k| k.chars().count() >= MIN_LETTERS && near(k) >= MIN_SIMILARITY);
    known.max_by(|a, b| near(a).total_cmp(&near(b))).copied()
}

/// A name as the table writes it: lower case, words joined by underscores, no unit in brackets.
fn normalised(name: &str) -> String {
    let name = name.split(['[', '(']).next().unwrap_or(name).trim();
    let small = name.trim_start_matches(['%', '#', '/']).to_lowercase();
    small.replace([' ', '-', '.', '/'], "_").trim_matches('_').into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::REGISTRY;
    use crate::method::settings::Settings;
    use crate::sensor::OVERRIDE_KEYS;

    const COLUMNS: [&str; 11] = ["t", "scan", "sensor", "px", "py", "ph", "x", "y", "h", "z", "label"];
    const SENSOR: [&str; 10] =
        ["id", "kind", "x", "y", "axis", "half_width", "r_min", "r_max", "hit_range", "no_echo_range"];

    #[track_caller]
    fn means(known: &[&str], cases: &[(&str, &str)]) {
        for (name, wanted) in cases {
            assert_eq!(closest(name, known).as_deref().unwrap_or("nothing"), *wanted, "{name}");
        }
    }

    #[test]
    fn columns_of_a_log() {
        means(
            &COLUMNS,
            &[
                ("theta", r#""ph" or "h""#),
                ("Theta", r#""ph" or "h""#),
                ("yaw", r#""ph" or "h""#),
                ("heading [rad]", r#""ph" or "h""#),
                ("angle", r#""ph" or "h""#),
                ("sensor_yaw", r#""h""#),
                ("range", r#""z""#),
                ("distance", r#""z""#),
                ("dist", r#""z""#),
                ("r", r#""z""#),
                ("time", r#""t" (in seconds)"#),
                ("timestamp", r#""t" (in seconds)"#),
                ("stamp", r#""t" (in seconds)"#),
                ("posex", r#""px" or "x""#),
                ("pose.y", r#""py" or "y""#),
                ("sensor_x", r#""x""#),
                ("PX", r#""px""#),
                ("seq", r#""scan""#),
                ("sensor_id", r#""sensor""#),
                ("class", r#""label""#),
                ("scn", r#""scan""#),
                ("sensr", r#""sensor""#),
                ("lable", r#""label""#),
                ("intensity", "nothing"),
                ("battery", "nothing"),
            ],
        );
    }

    #[test]
    fn keys_of_a_sensor() {
        means(
            &SENSOR,
            &[
                ("fov", r#""half_width" (half of the whole angle)"#),
                ("half_angle", r#""half_width""#),
                ("beta", r#""half_width""#),
                ("max_range", r#""r_max""#),
                ("range_min", r#""r_min""#),
                ("theta", r#""axis""#),
                ("half_witdh", r#""half_width""#),
                ("name", r#""id""#),
                ("type", r#""kind""#),
                ("colour", "nothing"),
            ],
        );
    }

    #[test]
    fn keys_of_set() {
        let keys = Settings::of("bayes").unwrap().keys();
        let known: Vec<&str> = keys.iter().chain(OVERRIDE_KEYS).map(|k| k.name).collect();
        means(
            &known,
            &[
                ("max_range", r#""r_max""#),
                ("min-range", r#""r_min""#),
                ("half_width", r#""beta""#),
                ("eps", r#""epsilon" (half the depth of the arc)"#),
                ("prob_hit", r#""p_hit""#),
                ("occ_thresh", r#""p_occupied""#),
                ("bta", r#""beta""#),
                ("rmax", r#""r_max""#),
                ("speed", "nothing"),
            ],
        );
    }

    #[test]
    fn methods() {
        let known: Vec<&str> = REGISTRY.iter().map(|e| e.name).collect();
        means(
            &known,
            &[
                ("elfes", r#""certainty""#),
                ("Moravec", r#""certainty""#),
                ("ds", r#""dempster-shafer""#),
                ("dempster", r#""dempster-shafer""#),
                ("dempster_shafer", r#""dempster-shafer""#),
                ("log-odds", r#""bayes""#),
                ("logodds", r#""bayes""#),
                ("bayesian", r#""bayes""#),
                ("vfh", r#""himm""#),
                ("csm", r#""csm-continuous" or "csm-discrete""#),
                ("semantic", r#""csm-semantic-continuous" or "csm-semantic-discrete""#),
                ("csm-discret", r#""csm-discrete""#),
                ("baye", r#""bayes""#),
                ("himn", r#""himm""#),
                ("xyz", "nothing"),
            ],
        );
    }

    /// Every name of the table exists, and no word stands twice in an entry.
    #[test]
    fn the_table_names_what_there_is() {
        let sets =
            REGISTRY.iter().flat_map(|e| Settings::of(e.name).unwrap().keys()).chain(OVERRIDE_KEYS).map(|k| k.name);
        let methods = REGISTRY.iter().map(|e| e.name);
        let known: Vec<&str> = sets
            .chain(methods)
            .chain(COLUMNS)
            .chain(SENSOR)
            .chain(["step", "first", "beams", "class", "ranges"])
            .collect();
        for (words, names, _) in SYNONYMS {
            for name in *names {
                assert!(known.contains(name), "{name}");
            }
            for word in *words {
                assert_eq!(normalised(word), *word);
                assert_eq!(words.iter().filter(|w| *w == word).count(), 1, "{word}");
            }
        }
    }
}
