//! "Did you mean …?": the known name that somebody had in mind, by the words that other programs use for it, else by its
//! spelling.

/// Words of other programs, and the names that mean the same here, the likeliest first. Of these the first two that are known
/// where the word was written are told. A remark says where the meaning isn't quite the same.
const SYNONYMS: &[(&[&str], &[&str], &str)] = &[
    // Columns of a log, keys of a sensor.
    (
        &[
            "theta",
            "yaw",
            "heading",
            "angle",
            "phi",
            "bearing",
            "orientation",
            "rotation",
            "rot",
            "psi",
            "th",
            "a",
            "azimuth",
            "robot_theta",
            "robot_yaw",
            "robot_heading",
            "robot_h",
            "pose_theta",
            "pose_yaw",
            "pose_h",
            "ptheta",
            "pyaw",
            "posetheta",
            "direction",
            "dir",
        ],
        &["ph", "h", "axis"],
        "",
    ),
    (
        &["sensor_theta", "sensor_yaw", "sensor_heading", "sensor_angle", "beam_angle", "mount_angle", "sh", "stheta"],
        &["h", "axis"],
        "",
    ),
    (
        &["posex", "pose_x", "pos_x", "robot_x", "x_robot", "robotx", "rx", "odom_x", "base_x", "easting"],
        &["px", "x"],
        "",
    ),
    (
        &["posey", "pose_y", "pos_y", "robot_y", "y_robot", "roboty", "ry", "odom_y", "base_y", "northing"],
        &["py", "y"],
        "",
    ),
    (&["sensor_x", "x_sensor", "sx", "mount_x", "offset_x", "forward"], &["x"], ""),
    (&["sensor_y", "y_sensor", "sy", "mount_y", "offset_y", "left"], &["y"], ""),
    (
        &[
            "range",
            "ranges",
            "distance",
            "dist",
            "d",
            "r",
            "reading",
            "measurement",
            "echo",
            "depth",
            "value",
            "length",
        ],
        &["z", "ranges", "r_max"],
        "",
    ),
    (
        &["time", "timestamp", "stamp", "time_s", "secs", "seconds", "sec", "t_s", "ts", "date", "time_stamp", "nsec"],
        &["t"],
        "in seconds",
    ),
    (
        &[
            "scan_id",
            "scanid",
            "seq",
            "sequence",
            "frame",
            "frame_id",
            "index",
            "idx",
            "sweep",
            "ping",
            "scan_index",
            "step",
        ],
        &["scan"],
        "",
    ),
    (
        &[
            "sonar",
            "laser",
            "lidar",
            "sensor_id",
            "sensorid",
            "transducer",
            "transducer_id",
            "beam",
            "beam_id",
            "channel",
            "topic",
            "name",
        ],
        &["sensor", "id"],
        "",
    ),
    (&["class", "class_id", "classid", "semantic", "category", "annotation"], &["label", "class"], ""),
    (&["type", "sensor_type", "sort"], &["kind"], ""),
    // What a sensor sees.
    (
        &[
            "fov",
            "field_of_view",
            "beam_width",
            "beamwidth",
            "opening_angle",
            "opening",
            "aperture",
            "width",
            "cone",
            "cone_angle",
            "cone_width",
            "angle_width",
            "beam_angle",
        ],
        &["half_width", "beta"],
        "half of the whole angle",
    ),
    (
        &["half_angle", "half_width", "halfwidth", "half_fov", "half_beam_width", "beta", "b"],
        &["half_width", "beta"],
        "",
    ),
    (
        &[
            "max_range",
            "range_max",
            "maxrange",
            "rangemax",
            "rmax",
            "max",
            "max_r",
            "z_max",
            "zmax",
            "maximum_range",
            "max_distance",
        ],
        &["r_max", "z_max"],
        "",
    ),
    (
        &["min_range", "range_min", "minrange", "rangemin", "rmin", "min", "min_r", "minimum_range", "min_distance"],
        &["r_min"],
        "",
    ),
    (
        &[
            "max_hit",
            "hit_max",
            "hit",
            "max_hit_range",
            "usable_range",
            "max_usable_range",
            "obstacle_range",
            "trusted_range",
        ],
        &["hit_range"],
        "",
    ),
    (
        &[
            "free_range",
            "raytrace_range",
            "clear_range",
            "no_echo",
            "noecho",
            "no_return",
            "no_return_range",
            "inf_range",
        ],
        &["no_echo_range"],
        "",
    ),
    (&["eps", "arc", "arc_depth", "thickness", "range_error", "tolerance"], &["epsilon"], "half the depth of the arc"),
    (&["mount", "mounting", "offset", "offsets", "extrinsics"], &["mounts"], ""),
    (&["angle_increment", "increment", "spacing", "angle_step", "resolution"], &["step"], ""),
    (&["angle_min", "first_angle", "start", "start_angle"], &["first"], ""),
    (&["count", "num_beams", "n_beams", "number_of_beams", "rays"], &["beams"], ""),
    // A method's parameters.
    (&["prob_hit", "hit_prob", "hit_probability"], &["p_hit"], ""),
    (&["prob_miss", "miss_prob", "miss_probability"], &["p_miss"], ""),
    (&["p_occ", "prob_occ", "prob_occupied"], &["p_occupied"], ""),
    (&["p_free", "p_emp", "prob_free", "prob_empty"], &["p_empty"], ""),
    (&["occupied_thresh", "occ_thresh", "occupied_threshold", "occ_threshold", "occupied"], &["p_occupied"], ""),
    (&["free_thresh", "free_threshold", "empty_threshold", "free", "empty"], &["p_empty"], ""),
    (&["growth", "growth_rate", "growth_rate_operator"], &["gro"], ""),
    (&["k", "knn", "nearest", "neighbors", "num_neighbours"], &["neighbours"], ""),
    (&["likelihood", "sensor_model", "inverse_model"], &["model"], ""),
    (&["alpha", "alpha_0", "alpha0", "dirichlet"], &["prior"], ""),
    (&["kernel_length", "length_scale", "kernel_radius", "kernel_size", "ell"], &["l"], ""),
    // Methods.
    (&["elfes", "moravec", "moravec_elfes", "certainty_grid", "certainty_grids", "cg"], &["certainty"], ""),
    (
        &["ds", "dst", "dempster", "shafer", "dempstershafer", "evidential", "evidence", "belief", "pagac", "d_s"],
        &["dempster-shafer"],
        "",
    ),
    (
        &[
            "log_odds",
            "logodds",
            "bayesian",
            "occupancy",
            "occupancy_grid",
            "ogm",
            "murphy",
            "thrun",
            "inverse_sensor_model",
            "ism",
            "binary_bayes",
            "probability",
            "octomap",
            "gmapping",
        ],
        &["bayes"],
        "",
    ),
    (&["vfh", "borenstein", "koren", "histogram", "histogrammic", "vff"], &["himm"], ""),
    (&["ground_truth", "groundtruth", "gt", "true", "laser_truth"], &["truth"], ""),
    (
        &["counting", "counting_sensor_model", "count", "csm", "kernel", "bki", "bgk", "dirichlet_csm"],
        &["csm-continuous", "csm-discrete"],
        "",
    ),
    (
        &["semantic", "semantic_csm", "csm_semantic", "semantics", "labels", "classes"],
        &["csm-semantic-continuous", "csm-semantic-discrete"],
        "",
    ),
    (&["feature", "fbog", "feature_based", "rcd", "walls", "corners"], &["features"], ""),
];

/// How like a spelling must be. Names of one or two letters are like too much: they are found by synonyms only.
const LIKE: f64 = 0.8;
const SHORTEST: usize = 3;

/// "; did you mean …?", or the list of what there is.
pub(crate) fn similar(name: &str, known: &[&str]) -> String {
    match meant(name, known) {
        Some(meant) => format!("; did you mean {meant}?"),
        None => format!("; known are {}", known.join(", ")),
    }
}

/// What was meant, in quotes and with what is to be said of it; nothing, if no known name is near.
pub(crate) fn meant(name: &str, known: &[&str]) -> Option<String> {
    let plain = plain(name);
    if let Some(same) = known.iter().find(|k| self::plain(k) == plain) {
        return Some(format!("{same:?}"));
    }
    let told = SYNONYMS.iter().filter(|(words, ..)| words.contains(&plain.as_str())).find_map(|(_, names, remark)| {
        let here: Vec<String> = names.iter().filter(|n| known.contains(n)).take(2).map(|n| format!("{n:?}")).collect();
        let remark = if remark.is_empty() { String::new() } else { format!(" ({remark})") };
        (!here.is_empty()).then(|| here.join(" or ") + &remark)
    });
    told.or_else(|| nearest(&plain, known).map(|near| format!("{near:?}")))
}

/// The known name whose spelling is nearest, if any is near.
fn nearest<'a>(plain: &str, known: &[&'a str]) -> Option<&'a str> {
    let near = |k: &str| strsim::jaro_winkler(plain, &self::plain(k));
    let known = known.iter().filter(|k| k.chars().count() >= SHORTEST && near(k) >= LIKE);
    known.max_by(|a, b| near(a).total_cmp(&near(b))).copied()
}

/// A name as the table writes it: small letters, one kind of joint, and no unit in brackets.
fn plain(name: &str) -> String {
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
            assert_eq!(meant(name, known).as_deref().unwrap_or("nothing"), *wanted, "{name}");
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

    /// A word that stands for nothing known, or twice for the same, is a slip in the table.
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
                assert_eq!(plain(word), *word);
                assert_eq!(words.iter().filter(|w| *w == word).count(), 1, "{word}");
            }
        }
    }
}
