//! verify, plan, doctor, bench, demo.

use crate::common::{Place, keys};
use echogrid::method::REGISTRY;
use serde_json::json;

/// Two scans of a laser and one of a sonar, so that every method has a log.
const BOTH: &str = r#"{"echogrid_log":1,"sensors":[{"id":"ring"},{"id":"top","kind":"laser","half_width":"1deg"}],"classes":["wall"]}
{"scan":0,"sensor":"ring","px":0,"py":0,"ph":0,"z":1.5,"label":1}
{"scan":0,"sensor":"top","px":0,"py":0,"ph":0,"z":2}
{"scan":1,"sensor":"ring","px":0.1,"py":0.05,"ph":0.7,"z":1.2}
{"scan":1,"sensor":"top","px":0.1,"py":0.05,"ph":0.7,"z":1.1}
"#;

#[test]
fn verify_passes_for_every_method() {
    let place = Place::new();
    place.write("both.jsonl", BOTH);
    for entry in REGISTRY {
        let kind = if entry.name == "truth" { "laser" } else { "sonar" };
        let ran = place.run(&["verify", "both.jsonl", "--method", entry.name, "--sensor", kind, "--json"]);
        let found = ran.json();
        assert_eq!(
            keys(&found),
            [
                "absent",
                "backends",
                "method",
                "oracle_seconds",
                "passed",
                "readings",
                "same_bytes",
                "size",
                "skipped",
                "updates"
            ]
        );
        // Without any adapter only the oracle and the cpu are compared, and that proves too little.
        let whole = found["skipped"] == json!([]);
        assert_eq!(ran.code, if whole { 0 } else { 4 }, "{ran:?}");
        assert_eq!(
            (&found["method"], &found["passed"], &found["readings"]),
            (&json!(entry.name), &json!(whole), &json!(2))
        );
        assert!(found["updates"].as_u64().unwrap() > 10, "{found}");
        let backends = found["backends"].as_array().unwrap();
        let skipped = found["skipped"].as_array().unwrap();
        assert_eq!(backends.len() + skipped.len(), 2, "{found}");
        assert_eq!(backends[0]["backend"], "cpu");
        for b in backends {
            assert_eq!(
                keys(b),
                [
                    "adapter",
                    "backend",
                    "class",
                    "class_wrong",
                    "counts",
                    "layers",
                    "membership",
                    "membership_cell",
                    "passed",
                    "seconds",
                    "updates"
                ]
            );
            for layer in b["layers"].as_array().unwrap() {
                let wanted = ["beyond", "bound", "largest", "largest_cell", "layer", "worst"];
                assert_eq!(keys(layer), wanted);
                let cell = &layer["largest_cell"];
                if cell.is_null() {
                    assert_eq!(layer["largest"], 0.0, "{layer}");
                    continue;
                }
                assert_eq!((&cell["difference"], &cell["bound"]), (&layer["largest"], &layer["bound"]));
                let share =
                    |cell: &serde_json::Value| cell["difference"].as_f64().unwrap() / cell["bound"].as_f64().unwrap();
                assert!(share(&layer["worst"]) >= share(cell) && share(&layer["worst"]) <= 1.0, "{layer}");
                let last = &cell["last_readings"][0];
                assert_eq!(keys(last), ["line", "range", "sensor"]);
                assert_eq!(last["sensor"], if kind == "sonar" { "ring" } else { "top" });
            }
            assert_eq!((&b["membership"], &b["class_wrong"], &b["counts"]), (&json!(0), &json!(0), &json!(0)));
            assert_eq!(b["updates"], found["updates"]);
        }
    }
}

#[test]
fn verify_as_a_table() {
    let place = Place::new();
    let ran = place.does(&["verify", "log.jsonl", "--backends", "cpu"]);
    let lines: Vec<&str> = ran.out.lines().collect();
    assert!(
        lines[0].starts_with("bayes: 4 readings, 50 × 38 cells, ") && lines[0].ends_with(" cell updates"),
        "{}",
        lines[0]
    );
    assert!(lines[1].starts_with("oracle  f64, one reading at a time ("), "{}", lines[1]);
    assert!(lines[2].starts_with("cpu     "), "{}", lines[2]);
    assert_eq!(lines[3], "  cells that other readings reach  0");
    assert_eq!(lines.last(), Some(&"equal"));
    for layer in ["log_odds", "p_occ", "p_emp"] {
        assert!(lines.iter().any(|l| l.trim_start().starts_with(layer) && l.contains(", bound there ")), "{layer}");
    }
}

#[test]
fn verify_quietly_and_within_memory() {
    let place = Place::new();
    let ran = place.does(&["verify", "log.jsonl", "--backends", "cpu", "--quiet"]);
    assert_eq!((ran.out.as_str(), ran.err.as_str()), ("", ""));
    let ran = place.does(&["verify", "log.jsonl", "--backends", "cpu", "--quiet", "--json"]);
    assert_eq!(ran.json()["passed"], true);
    let ran = place.run(&["verify", "log.jsonl", "--backends", "cpu", "--memory", "1MB"]);
    assert_eq!(ran.code, 5);
    assert!(ran.err.contains(", but --memory allows 977 KiB: "), "{}", ran.err);
    // Each cell is told with how far it is off and may be, and which readings made it.
    let ran = place.does(&["verify", "log.jsonl", "--backends", "cpu"]);
    assert!(ran.out.lines().all(|l| l.chars().count() <= 100), "{}", ran.out);
    let joined = ran.out.replace("\n      ", " ");
    let cells: Vec<&str> = joined.lines().filter(|l| l.contains(": cell (")).collect();
    assert!(!cells.is_empty());
    for line in cells {
        assert!(line.trim_start().starts_with("largest") || line.trim_start().starts_with("nearest"), "{line}");
        assert!(line.contains(", difference ") && line.contains(", bound "), "{line}");
        assert!(line.contains("; last readings: line ") && line.contains(" sensor front ("), "{line}");
    }
}

#[test]
fn plan_says_what_it_would_take_and_does_nothing() {
    let place = Place::new();
    let before = place.names("");
    let ran = place.does(&["plan", "log.jsonl"]);
    let heads: Vec<&str> = ran.out.lines().map(|l| l.split("  ").next().unwrap()).take(9).collect();
    assert_eq!(heads, ["log", "readings", "grid", "chunks", "", "round 1", "memory", "card", "disk"]);
    assert!(ran.out.lines().all(|l| l.chars().count() <= 100), "{}", ran.out);
    let cpu = ran.out.lines().find(|l| l.starts_with("cpu       about ")).unwrap();
    assert!(cpu.contains(" k readings/s, ") && cpu.contains(" s to write a chunk ("), "{cpu}");
    for line in [
        "log       echogrid-jsonl, 1 sensor",
        "readings  4 used of 8 in 4 scans, 0 bad lines, 0 other lines",
        "grid      50 × 38 cells of 0.05 m from (0.00, -0.45) to (2.50, 1.45) m",
        "  beta = 15 deg",
        "  r_max = 4 m",
        "  max_occ = 0.98",
    ] {
        assert!(ran.out.lines().any(|l| l == line), "{line}: {}", ran.out);
    }
    let plan = place.does(&["plan", "log.jsonl", "--json"]).json();
    assert_eq!(
        (&plan["method"], &plan["format"], &plan["scans"]),
        (&json!("bayes"), &json!("echogrid-jsonl"), &json!(4))
    );
    assert_eq!((&plan["cells"]["width"], &plan["readings"]["used"]), (&json!(50), &json!(4)));
    assert_eq!((&plan["parameters"]["r_max"], &plan["parameters"]["max_occ"]), (&json!("4"), &json!("0.98")));
    assert_eq!((&plan["chunks"][0]["row"], &plan["chunks"][0]["column"]), (&json!(0), &json!(0)));
    assert!(plan["card"].as_u64().unwrap() > 4 * 20 * (1 << 20), "four chunks of 20 bytes a cell: {plan}");
    assert_eq!((&plan["chunks"][0]["readings"], &plan["binned"]), (&json!(4), &json!(4)));
    assert_eq!((&plan["fits"], &plan["rounds"]), (&json!(true), &json!(["fuse"])));
    let expected = |more: &[&str]| {
        let plan = place.does(&[&["plan", "log.jsonl", "--json"], more].concat()).json();
        let all = plan["expected"].as_array().unwrap().clone();
        assert_eq!(all.len(), 1, "one backend is told: {plan}");
        all[0].clone()
    };
    let cpu = expected(&["--backend", "cpu"]);
    assert_eq!((&cpu["backend"], &cpu["why"]), (&json!("cpu"), &json!("")));
    let oracle = expected(&["--backend", "oracle"]);
    assert_eq!(oracle["backend"], "oracle");
    assert!(oracle["readings_per_second"].as_f64().unwrap() > 1.0, "{oracle}");
    // Without a choice it is what `map` would take.
    let auto = expected(&[]);
    assert!(auto["why"].as_str().unwrap().contains("hardware"), "{auto}");
    assert!(cpu["readings_per_second"].as_f64().unwrap() > 1.0 && cpu["seconds"].as_f64().unwrap() < 60.0, "{cpu}");
    let plan_of = |method: &str| place.does(&["plan", "log.jsonl", "-m", method, "--json"]).json()["rounds"].clone();
    assert_eq!(plan_of("certainty"), json!(["weigh, then sum, then hand over, then fuse", "fuse"]));
    assert_eq!(plan_of("dempster-shafer"), json!(["count, then tally", "fuse"]));
    let gro = place.does(&["plan", "log.jsonl", "-m", "himm", "--set", "gro=true", "--json"]).json();
    assert_eq!((&gro["fits"], &gro["rounds"]), (&json!(true), &json!(["fuse"])));
    assert!(ran.out.lines().any(|l| l.starts_with("memory    about ")), "{}", ran.out);
    assert!(!ran.out.contains("does not fit"), "{}", ran.out);
    // What is too large for the machine is said, and is no error here.
    #[cfg(target_os = "linux")]
    {
        let large = ["plan", "log.jsonl", "--bounds", "0,0,300000,300000"];
        let ran = place.does(&large);
        let joined = ran.out.split_whitespace().collect::<Vec<_>>().join(" ");
        let why = "does not fit: the files of a map of 6000000 × 6000000 cells of 0.05 m take 44 TiB and more, but there are ";
        assert!(joined.contains(why), "{}", ran.out);
        assert_eq!(place.does(&[&large[..], &["--json"]].concat()).json()["fits"], false);
    }
    // The plan's figure is the one that --memory is held against.
    let need = plan["memory"].as_u64().unwrap();
    let map = |memory: u64| place.run(&["map", "log.jsonl", "-o", "out", "--memory", &memory.to_string()]).code;
    // A smaller cap makes smaller batches, down to a thousand readings; there are four.
    assert_eq!((map(need - 1), place.names("") == before, map(need)), (5, true, 0));
}

#[test]
fn doctor() {
    let place = Place::new();
    let ran = place.does(&["doctor"]);
    let lines: Vec<&str> = ran.out.lines().collect();
    assert_eq!(lines[0], format!("echogrid {}", env!("CARGO_PKG_VERSION")));
    assert!(lines[1].starts_with("cpu       ") && lines[1].contains("thread"), "{}", lines[1]);
    assert!(lines.iter().all(|l| l.chars().count() <= 100), "{}", ran.out);
    assert!(lines.iter().any(|l| l.starts_with("adapter   ")), "{}", ran.out);
    for entry in REGISTRY {
        assert!(lines.iter().any(|l| l.starts_with(&format!("{} ", entry.name))), "{}: {}", entry.name, ran.out);
    }
    let found = place.does(&["doctor", "--json"]).json();
    assert_eq!(keys(&found), ["adapters", "cpu", "memory_available", "methods", "version", "vulkan"]);
    let methods = found["methods"].as_array().unwrap();
    assert_eq!(
        methods.iter().map(|m| m["method"].as_str().unwrap()).collect::<Vec<_>>(),
        REGISTRY.iter().map(|e| e.name).collect::<Vec<_>>()
    );
    for method in methods {
        assert_eq!(keys(method), ["auto", "bytes_a_cell", "method"]);
        assert!(
            method["bytes_a_cell"].as_u64().unwrap() >= 4 && !method["auto"].as_str().unwrap().is_empty(),
            "{method}"
        );
    }
    for adapter in found["adapters"].as_array().unwrap() {
        assert!(!adapter["name"].as_str().unwrap().is_empty() && adapter["binding"].as_u64().unwrap() >= 1 << 27);
    }
}

#[test]
fn bench_gives_figures_for_every_method() {
    let place = Place::new();
    let found = place.does(&["bench", "--readings", "200", "--runs", "1", "--json"]).json();
    assert_eq!(keys(&found), ["backends", "measured", "version"]);
    let most = &found["backends"][0]["ceilings"];
    for what in ["flop", "int", "bytes"] {
        assert!(most[what].as_f64().unwrap() > 1e8, "{most}");
    }
    for entry in REGISTRY.iter().filter(|e| e.name != "truth") {
        let of_cpu = |m: &&serde_json::Value| m["method"] == entry.name && m["backend"] == "cpu";
        let measured: Vec<_> = found["measured"].as_array().unwrap().iter().filter(of_cpu).collect();
        let scans = entry.name.starts_with("csm-");
        assert_eq!(measured.len(), if scans { 2 } else { 4 }, "{}", entry.name);
        for m in measured {
            let readings = if scans { 180 } else { 200 };
            assert_eq!((&m["readings"], m["seconds"].as_array().unwrap().len()), (&json!(readings), 1));
            for figure in ["updates_per_second", "readings_per_second", "updates", "median"] {
                assert!(m[figure].as_f64().unwrap() > 0.0, "{figure}: {m}");
            }
            let rate = m["updates"].as_f64().unwrap() / m["median"].as_f64().unwrap();
            assert!((rate / m["updates_per_second"].as_f64().unwrap() - 1.0).abs() < 1e-6, "{m}");
            // the share of the ceiling that binds, from what an update costs
            let (share, of) = (m["ceiling"][0].as_f64().unwrap(), m["ceiling"][1].as_str().unwrap());
            let wanted =
                m[of].as_f64().unwrap() * m["updates_per_second"].as_f64().unwrap() / most[of].as_f64().unwrap();
            assert!((share / wanted - 1.0).abs() < 1e-6 && share < 1.5, "{m}");
            // … and of the passes alone, by their own time
            let alone: f64 = m["passes"].as_array().unwrap().iter().map(|p| p[1].as_f64().unwrap()).sum();
            let (share, of) = (m["kernels"][0].as_f64().unwrap(), m["kernels"][1].as_str().unwrap());
            let wanted = m[of].as_f64().unwrap() * m["updates"].as_f64().unwrap() / alone / most[of].as_f64().unwrap();
            assert!((share / wanted - 1.0).abs() < 1e-6, "{m}");
            let passes: Vec<_> = m["passes"].as_array().unwrap().iter().map(|p| p[0].as_str().unwrap()).collect();
            let wanted: &[&str] = match entry.name {
                "certainty" => &["fuse", "sum", "weigh"],
                "dempster-shafer" => &["count", "fuse"],
                _ => &["fuse"],
            };
            assert_eq!(passes, wanted, "{m}");
        }
    }
    let ran =
        place.does(&["bench", "log.jsonl", "-m", "himm,bayes", "--backends", "cpu", "--readings", "20", "--runs", "2"]);
    let lines: Vec<&str> = ran.out.lines().collect();
    assert!(lines[0].starts_with("cpu: "), "{}", lines[0]);
    assert_eq!(
        lines[2].split_whitespace().collect::<Vec<_>>().join(" "),
        "M updates k readings whole binning per of the limit"
    );
    let heads = ["workload", "a", "second", "a", "second", "ms", "ms", "update", "whole", "in", "kernels"];
    assert_eq!(lines[3].split_whitespace().collect::<Vec<_>>(), heads);
    assert!(lines[1].starts_with("at most ") && lines[1].contains(" GFLOP/s (fused), "), "{}", lines[1]);
    // Four workloads and the log, twice, each under its method; then what the columns mean.
    assert_eq!((lines[4], lines[10], lines[16]), ("himm", "bayes", ""), "{}", ran.out);
    assert!(lines[9].starts_with("  log.jsonl, 5 cm"), "{}", lines[9]);
    for word in ["M updates: ", "whole: ", "binning: ", "per update: ", "of the limit: ", "in kernels: "] {
        assert!(lines[17..].iter().any(|l| l.contains(word)), "{word}: {}", ran.out);
    }
    assert!(lines.iter().all(|l| l.chars().count() <= 100), "{}", ran.out);
    // A method of several kernels tells the time of each.
    let ran = place.does(&["bench", "-m", "certainty", "--backends", "cpu", "--readings", "20", "--runs", "1"]);
    let kernels: Vec<&str> = ran.out.lines().filter(|l| l.starts_with("    of which kernels, ms: fuse ")).collect();
    assert!(kernels.len() == 4 && kernels.iter().all(|l| l.contains(", weigh ")), "{}", ran.out);
}

#[test]
fn bench_compares_grows_and_prints_markdown() {
    let place = Place::new();
    let small = ["bench", "-m", "himm", "--backends", "cpu", "--readings", "10", "--runs", "1"];
    place.write("old.json", place.does(&[&small[..], &["--json"]].concat()).out);
    let ran = place.does(&[&small[..], &["--compare", "old.json"]].concat());
    let lines: Vec<&str> = ran.out.lines().skip(3).collect();
    assert!(lines[0].ends_with("before") && lines[2..6].iter().all(|l| l.ends_with(" x")), "{}", ran.out);
    assert!(ran.out.lines().all(|l| l.chars().count() <= 100), "{}", ran.out);
    let ran = place.does(&[&small[..], &["--markdown"]].concat());
    let table: Vec<&str> = ran.out.lines().filter(|l| l.starts_with('|')).collect();
    assert_eq!(table.len(), 2 + 4, "{}", ran.out);
    assert!(table.iter().all(|l| l.matches('|').count() == 11 && l.ends_with('|')), "{}", ran.out);
    let found = place.does(&[&small[..], &["--growth", "--json"]].concat()).json();
    let row = |k: usize| (found["measured"][k]["workload"].as_str().unwrap(), &found["measured"][k]["readings"]);
    assert_eq!(
        [row(0), row(3), row(7)],
        [("readings x 1", &json!(10)), ("readings x 64", &json!(640)), ("cells x 64", &json!(10))]
    );
    place.write("odd.json", "{}");
    place.refuses(
        &[&small[..], &["--compare", "odd.json"]].concat(),
        3,
        "echogrid: odd.json: it has no figures: give what bench --json printed",
    );
}

#[test]
fn bench_refuses_truth_and_keeps_its_columns() {
    let place = Place::new();
    let message = "echogrid: truth needs the wedges of laser scans; bench measures the other methods";
    place.refuses(&["bench", "-m", "himm,truth"], 2, message);
    let small = ["-m", "himm", "--backends", "cpu", "--readings", "20", "--runs", "1"];
    for (name, shown) in [
        ("a_log_of_a_length.jsonl", "a_log_of_a_length.jsonl, 5 cm".to_string()),
        (&format!("{}.jsonl", "é".repeat(60)), format!("{}…", "é".repeat(29))),
    ] {
        place.write(name, crate::common::SMALL);
        let ran = place.does(&[&["bench", name], &small[..]].concat());
        // The heads, the method, four workloads, the log.
        let lines: Vec<&str> = ran.out.lines().skip(3).take(7).collect();
        assert!(lines[6].starts_with(&format!("  {shown}  ")), "{}", ran.out);
        let widths: Vec<usize> = lines[2..].iter().map(|l| l.chars().count()).collect();
        assert_eq!(widths, [lines[0].chars().count(); 5], "{}", ran.out);
    }
}

#[test]
fn demo_maps_and_scores_a_corridor_by_every_method() {
    let place = Place::new();
    let ran = place.does(&["demo", "-o", "deep/demo", "--backend", "cpu"]);
    let lines: Vec<&str> = ran.out.lines().collect();
    assert_eq!(lines[0], "A sonar turns in a bent corridor: 4800 readings in 24 scans, 59 % without an echo.");
    assert_eq!(lines[2], "map                       backend      ms  M updates  accuracy  recall  precision  danger");
    let mut names: Vec<&str> = REGISTRY.iter().map(|e| e.name).filter(|n| *n != "truth").collect();
    names.push("bayes-2m");
    let mut dangers = Vec::new();
    for (line, name) in lines[3..].iter().zip(&names) {
        let row: Vec<&str> = line.split_whitespace().collect();
        assert_eq!((row[0], row[1], row.len()), (*name, "cpu", 8), "{line}");
        let number = |k: usize| row[k].parse::<f64>().unwrap();
        assert!(number(3) > 0.0 && number(4) > 0.9 && (4..8).all(|k| (0.0..=1.0).contains(&number(k))), "{line}");
        assert!(place.path(&format!("deep/demo/{name}/map.png")).exists());
        assert!(place.path(&format!("deep/demo/score/{name}.errors.png")).exists());
        // the table's figures are those of `echogrid score`
        let folder = format!("deep/demo/{name}");
        let json = place.does(&["score", &folder, "--truth", "deep/demo/bend.toml", "--json"]).json();
        let danger = json["maps"][0]["danger"].as_f64().unwrap();
        assert_eq!(row[7], format!("{danger:.3}"));
        dangers.push(danger);
    }
    // what the text under the table says
    assert!(dangers[dangers.len() - 1] < 0.5 * dangers[2], "{dangers:?}");
    let danger = |name: &str| format!("{:.3}", dangers[names.iter().position(|n| *n == name).unwrap()]);
    let [features, bayes, near] = ["features", "bayes", "bayes-2m"].map(danger);
    let which = format!("features (danger {features}); the default, bayes, has {bayes}, with hit_range=2 {near}.");
    assert!(ran.out.contains(&which), "{which}: {}", ran.out);
    // and what README.md and docs/methods.md say of it
    for document in ["README.md", "docs/methods.md"] {
        let text = std::fs::read_to_string(format!("{}/{document}", env!("CARGO_MANIFEST_DIR"))).unwrap();
        let which = text.split("# Which method?").nth(1).and_then(|t| t.split("\n- **A sparse").next()).unwrap();
        for figure in [&features, &bayes, &near] {
            assert!(which.contains(&figure[1..]), "{document} has no {figure}: {which}");
        }
    }
    let seconds = ran.out.split(" In ").nth(1).unwrap().split(' ').next().unwrap().parse::<f64>().unwrap();
    assert!(seconds < 10.0, "{seconds} s");
    let page = std::fs::read_to_string(place.path("deep/demo/score/score.html")).unwrap();
    assert!(ran.out.contains("Look at deep/demo/score/score.html, then map a log of your own"), "{}", ran.out);
    assert!(names.iter().all(|n| page.contains(&format!("<h2>{n} "))), "a map is missing in score.html");
    names.extend(["bend.jsonl", "bend.toml", "score"]);
    names.sort_unstable();
    assert_eq!(place.names("deep/demo"), names);
    // Its log is one to try things on, and a second demo replaces the first.
    place.does(&["plan", "deep/demo/bend.jsonl"]);
    place.does(&["demo", "-o", "deep/demo", "--backend", "cpu"]);
}
