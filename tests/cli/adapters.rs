//! A machine without a GPU adapter: the loader is shown no driver.

#![cfg(target_os = "linux")]

use crate::common::{Place, Ran};
use echogrid::method::REGISTRY;

const NONE: &str = "there is no GPU adapter: VK_DRIVER_FILES names no driver that can be used (HERE/no-driver.json: there is no \
                    such file): mend it or unset VK_DRIVER_FILES; VK_LOADER_DEBUG=error shows what the Vulkan loader says; or \
                    use --backend cpu";

#[track_caller]
fn refused(place: &Place, ran: &Ran) {
    assert_eq!((ran.code, ran.err.as_str(), ran.out.as_str()), (4, format!("echogrid: {NONE}\n").as_str(), ""));
    assert_eq!(place.names(""), ["log.jsonl", "run"]);
}

#[test]
fn the_gpu_is_demanded() {
    let place = Place::new();
    refused(&place, &place.run_without_adapter(&["map", "log.jsonl", "-o", "out", "--backend", "gpu"], false));
}

#[test]
fn auto_takes_the_cpu_and_says_why() {
    let place = Place::new();
    let ran = place.run_without_adapter(&["map", "log.jsonl", "-o", "out"], false);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    let line = ran.out.lines().find(|l| l.starts_with("cpu (")).unwrap();
    let why = "), because there is no hardware GPU adapter (HERE/no-driver.json: there is no such file); ";
    assert!(line.contains(why), "{line}");
    assert_eq!(place.report("out")["backend"], "cpu");
    // Auto asks for no gpu, so it may still take the CPU.
    assert_eq!(place.run_without_adapter(&["map", "log.jsonl", "-o", "out"], true).code, 0);
}

#[test]
fn verify_without_the_gpu_is_no_equality() {
    let place = Place::new();
    let without = format!("gpu: {NONE}; `--backends oracle,cpu` compares without it\n");
    let missing = format!("echogrid: not verified: {without}");
    let ran = place.run_without_adapter(&["verify", "log.jsonl"], false);
    assert_eq!((ran.code, ran.err.as_str()), (4, missing.as_str()));
    assert!(ran.out.contains("\ncpu "), "{}", ran.out);
    let joined = ran.out.split_whitespace().collect::<Vec<_>>().join(" ");
    let end = format!(" SKIPPED gpu: {NONE} NOT VERIFIED: only oracle and cpu were compared, and are equal");
    assert!(joined.ends_with(&end), "{}", ran.out);
    let ran = place.run_without_adapter(&["verify", "log.jsonl", "--json"], false);
    assert_eq!((ran.code, ran.err.as_str()), (4, missing.as_str()));
    assert_eq!(ran.json()["skipped"][0], format!("gpu: {NONE}"));
    assert_eq!((&ran.json()["passed"], ran.json()["backends"].as_array().unwrap().len()), (&false.into(), 1));
    for backends in ["cpu,gpu", "gpu,oracle,cpu"] {
        let ran = place.run_without_adapter(&["verify", "log.jsonl", "--quiet", "--backends", backends], false);
        assert_eq!((ran.code, ran.err.as_str(), ran.out.as_str()), (4, missing.as_str(), ""), "{backends}");
    }
    let ran = place.run_without_adapter(&["verify", "log.jsonl", "--backends", "gpu"], false);
    let nothing = format!("echogrid: there is nothing to verify: {without}");
    assert_eq!((ran.code, ran.err.as_str(), ran.out.as_str()), (4, nothing.as_str(), ""));
    // Where it is demanded, the run isn't begun.
    refused(&place, &place.run_without_adapter(&["verify", "log.jsonl"], true));
    // Who asks for these two gets what was asked for.
    for backends in ["cpu", "oracle,cpu"] {
        let ran = place.run_without_adapter(&["verify", "log.jsonl", "--backends", backends], true);
        assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{backends}");
        assert!(ran.out.ends_with("\nequal\n"), "{}", ran.out);
    }
}

#[test]
fn bench_skips_loudly_or_fails() {
    let place = Place::new();
    let bench = ["bench", "--readings", "20", "--runs", "1", "--methods", "himm", "--json"];
    let ran = place.run_without_adapter(&bench, false);
    assert_eq!((ran.code, ran.err.as_str()), (0, format!("echogrid: SKIPPED gpu: {NONE}\n").as_str()));
    assert!(ran.json()["measured"].as_array().unwrap().iter().all(|m| m["backend"] == "cpu"));
    refused(&place, &place.run_without_adapter(&bench, true));
}

#[test]
fn doctor_says_how_to_get_one() {
    let ran = Place::new().run_without_adapter(&["doctor"], false);
    assert_eq!(ran.code, 0);
    let joined = ran.out.split_whitespace().collect::<Vec<_>>().join(" ");
    let why = NONE.split_once(": ").unwrap().1;
    assert!(joined.contains(&format!(" adapter none: {why} ")), "{}", ran.out);
    for entry in REGISTRY {
        let line = ran.out.lines().find(|l| l.starts_with(entry.name)).unwrap();
        assert!(line.ends_with(" cpu"), "{line}");
    }
}

#[test]
fn what_no_adapter_could_do_is_no_missing_adapter() {
    let place = Place::new();
    let gro = ["--method", "himm", "--set", "gro=true"];
    let why =
        "himm's growth-rate operator reads neighbouring cells in log order, which no gather can: use --backend cpu";
    let ran = place.run_without_adapter(&[&["verify", "log.jsonl"], &gro[..]].concat(), true);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    let none = format!("gpu: there is none for this method: {}", why.replace(": use --backend cpu", ""));
    let none = format!("{none}; oracle and cpu are all there is");
    let joined = ran.out.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(joined.ends_with(&format!(" {none} equal")), "{}", ran.out);
    let json = place.does(&[&["verify", "log.jsonl", "--json"], &gro[..]].concat()).json();
    assert_eq!(
        (&json["passed"], &json["absent"][0], &json["skipped"]),
        (&true.into(), &none.into(), &serde_json::json!([]))
    );
    let alone = place.run(&[&["verify", "log.jsonl", "--backends", "gpu"], &gro[..]].concat());
    assert!(
        alone.code == 4 && alone.err.contains("nothing to verify: gpu: there is none for this method"),
        "{alone:?}"
    );
    place.refuses(
        &[&["map", "log.jsonl", "-o", "out", "--backend", "gpu"], &gro[..]].concat(),
        4,
        &format!("echogrid: {why}"),
    );
    let ran = place.does(&[&["map", "log.jsonl", "-o", "out"], &gro[..]].concat());
    assert!(ran.out.contains("), because himm's growth-rate operator reads neighbouring cells"), "{}", ran.out);
}

#[test]
fn a_broken_driver_file_is_named_with_what_is_wrong() {
    let place = Place::new();
    let gpu = ["map", "log.jsonl", "-o", "out", "--backend", "gpu"];
    for (text, what) in [
        ("{\"ICD\": {\"library_path\": ", "it is not JSON (EOF while parsing a value at line 1 column 25)"),
        ("{\"file_format_version\": \"1.0.0\"}", "it names no library (ICD.library_path)"),
        ("{\"ICD\": {\"library_path\": \"./gone.so\"}}", "its library HERE/./gone.so isn't there"),
        (
            "{\"ICD\": {\"library_path\": \"libc.so.6\"}}",
            "its library libc.so.6 can't be used (it is no Vulkan driver)",
        ),
    ] {
        place.write("broken.json", text);
        for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
            let mut command = place.command(&gpu);
            command.env_remove("VK_DRIVER_FILES").env_remove("VK_ICD_FILENAMES");
            let ran = place.finish(command.env(variable, place.path("broken.json")));
            let wanted =
                format!("GPU adapter: {variable} names no driver that can be used (HERE/broken.json: {what}): mend it");
            assert!(ran.code == 4 && ran.err.contains(&wanted), "{text}: {ran:?}");
            assert!(ran.err.contains("VK_LOADER_DEBUG=error") && !ran.err.contains("install"), "{ran:?}");
        }
        // One among the user's own drivers, beside those of the system.
        let home = place.path("run/home");
        let folder = home.join(".local/share/vulkan/icd.d");
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("broken.json"), text).unwrap();
        let mut command = place.command(&["doctor"]);
        for name in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES", "XDG_DATA_HOME"] {
            command.env_remove(name);
        }
        let ran = place.finish(command.env("HOME", &home));
        let joined = ran.out.split_whitespace().collect::<Vec<_>>().join(" ");
        let what = what.replace("HERE/./gone.so", "HERE/run/home/.local/share/vulkan/icd.d/./gone.so");
        let wanted = format!("HERE/run/home/.local/share/vulkan/icd.d/broken.json: {what}");
        assert!(ran.code == 0 && joined.contains(&wanted), "{wanted}: {}", ran.out);
    }
}

#[test]
fn the_program_finds_itself_a_runtime_folder() {
    let place = Place::new();
    for given in [None, Some(""), Some("relative")] {
        let mut command = place.command(&["doctor"]);
        command.env_remove("XDG_RUNTIME_DIR").env("TMPDIR", place.path("run"));
        given.map(|folder| command.env("XDG_RUNTIME_DIR", folder));
        let ran = place.finish(&mut command);
        assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{given:?}");
        assert_eq!(place.names("run"), [""; 0], "its folder stays");
    }
}
