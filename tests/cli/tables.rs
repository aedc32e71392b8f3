//! Logs whose columns and poses the command line names: the same options for every command that takes a log.

use crate::common::Place;

const TABLE: &str = "time_ms;pos_x;pos_y;yaw_deg;bat;dist_cm\n0;0;0;0;12,1;150,5\n500;0,5;0;45;12,0;100\n";
const COLUMNS: &str = "t:ms,x,y,heading:deg,-,range:cm";

#[test]
fn a_table_is_mapped_planned_and_verified() {
    let place = Place::new();
    place.write("run.csv", TABLE);
    let what = "its columns are not those of a log that is known. Name its columns: --columns t:ms,x,y,heading:deg,-,range:cm; - skips one, \
                units as in x:mm or heading:deg (docs/formats.md)";
    let ran = place.run(&["plan", "run.csv"]);
    assert_eq!((ran.code, ran.err.trim_end()), (3, format!("echogrid: run.csv:1: {what}").as_str()));
    let ran = place.does(&["map", "run.csv", "-o", "out", "--backend", "cpu", "--columns", COLUMNS]);
    assert!(ran.err.contains("decimal commas") && ran.err.contains("taken to be a sonar's"), "{ran:?}");
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(place.path("out/report.json")).unwrap()).unwrap();
    assert_eq!(report["parameters"]["columns"], COLUMNS);
    assert_eq!(report["readings"]["used"], 2);
    place.does(&["plan", "run.csv", "--columns", COLUMNS]);
    place.does(&["verify", "run.csv", "--columns", COLUMNS, "--backends", "cpu"]);
    let ran = place.run(&["map", "run.csv", "-o", "bad", "--columns", "t,x"]);
    assert_eq!(ran.code, 2, "{ran:?}");
}

#[test]
fn poses_come_from_a_second_file() {
    let place = Place::new();
    place.write("ranges.txt", "0 1.5\n1 1.25\n7 1\n");
    place.write("poses.txt", "0 0 0 0\n2 1 0 0\n");
    let columns = ["--columns", "t,range"];
    let ran = place.run(&[&["map", "ranges.txt", "-o", "out"][..], &columns].concat());
    assert!(ran.code == 3 && ran.err.contains("give a file of poses by time with --poses FILE"), "{ran:?}");
    let more = ["--poses", "poses.txt", "--backend", "cpu"];
    let ran = place.does(&[&["map", "ranges.txt", "-o", "out"][..], &columns, &more].concat());
    assert!(ran.err.contains("1 readings were left out: at their times there is no pose"), "{ran:?}");
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(place.path("out/report.json")).unwrap()).unwrap();
    assert_eq!(report["readings"]["used"], 2);
}
