//! README.md against the program: its table of methods is the registry, its commands parse.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use clap::Parser;
use echogrid::cli::Arguments;
use echogrid::method::REGISTRY;

fn readme() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// The commands in its console and sh blocks that call the program: continued lines joined, prompt and comment off.
fn commands(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let (mut shell, mut open) = (false, String::new());
    for line in text.lines() {
        if let Some(language) = line.trim_start().strip_prefix("```") {
            shell = ["console", "sh", "bash", "shell"].contains(&language.trim());
            continue;
        }
        if !shell {
            continue;
        }
        open += line.trim_start().trim_start_matches("$ ");
        if let Some(more) = open.strip_suffix('\\') {
            open = more.to_string();
            continue;
        }
        let command = std::mem::take(&mut open);
        let command = command.split(" #").next().unwrap_or_default();
        found.extend(command.split("&&").flat_map(|c| c.split('|')).map(|c| c.trim().to_string()));
    }
    found.retain(|c| c == "echogrid" || c.starts_with("echogrid "));
    found
}

/// The words of a command as a shell gives them, up to a redirection.
fn words(command: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for c in command.chars() {
        match (quote, c) {
            (Some(q), c) if c == q => quote = None,
            (None, '\'' | '"') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (None, c) if c.is_whitespace() => words.extend(word.take()),
            (None, '>' | ';') => break,
            (_, c) => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    words
}

#[test]
fn its_commands_parse() {
    let all = commands(&readme());
    assert!(!all.is_empty(), "README.md shows no command");
    for command in all {
        if let Err(e) = Arguments::try_parse_from(words(&command)) {
            let shown =
                matches!(e.kind(), clap::error::ErrorKind::DisplayHelp | clap::error::ErrorKind::DisplayVersion);
            assert!(shown, "README.md: {command}\n{e}");
        }
    }
}

#[test]
fn its_commands_run_one_after_the_other() {
    let folder = tempfile::tempdir().unwrap();
    // a log of a sonar and a laser, as the block's LOG has both
    let line = |scan: u32, sensor: &str, z: f64| {
        format!("{{\"scan\":{scan},\"sensor\":\"{sensor}\",\"px\":0.{scan},\"py\":0,\"ph\":0.{scan},\"z\":{z}}}\n")
    };
    let mut log = String::from(
        "{\"echogrid_log\":1,\"sensors\":[{\"id\":\"s\"},{\"id\":\"l\",\"kind\":\"laser\",\"half_width\":\"1deg\"}]}\n",
    );
    (0..5).for_each(|k| log += &(line(k, "s", 1.2) + &line(k, "l", 2.0)));
    std::fs::write(folder.path().join("LOG"), log).unwrap();
    let worlds = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("worlds");
    std::fs::create_dir(folder.path().join("worlds")).unwrap();
    std::fs::copy(worlds.join("bend.toml"), folder.path().join("worlds/bend.toml")).unwrap();
    let mut ran = 0;
    for command in commands(&readme()) {
        // a benchmark takes its time, and says nothing here; a page is served until somebody ends it
        if command == "echogrid bench" || command.contains("demo") || command.starts_with("echogrid view") {
            continue;
        }
        let run = std::process::Command::new(env!("CARGO_BIN_EXE_echogrid"))
            .current_dir(folder.path())
            .args(&words(&command)[1..])
            .output()
            .unwrap();
        // out and other may be made by different backends
        let code = run.status.code().unwrap_or(-1);
        assert!(code == 0 || (code == 1 && command.contains("compare")), "{command}: {run:?}");
        ran += 1;
    }
    assert!(ran >= 9, "{ran} commands ran");
}

#[test]
fn commands_are_found_and_taken_apart() {
    let text = "```console\n$ echogrid map a.log \\\n    -o 'my map' > x  # a comment\nmethod  bayes\n$ cargo build && echogrid demo\n\
                ```\n```rust\nechogrid map\n```\n```sh\nechogrid doctor | head\n```\n";
    let found = commands(text);
    assert_eq!(found, ["echogrid map a.log -o 'my map' > x", "echogrid demo", "echogrid doctor"]);
    assert_eq!(words(&found[0]), ["echogrid", "map", "a.log", "-o", "my map"]);
    assert!(Arguments::try_parse_from(words("echogrid map a.log --no-such-option")).is_err());
}

/// The cells of each row of a table.
fn row(line: &str) -> Option<Vec<String>> {
    let inner = line.trim().strip_prefix('|')?.strip_suffix('|')?;
    Some(inner.split('|').map(|cell| cell.trim().to_string()).collect())
}

#[test]
fn its_table_of_methods_is_the_registry() {
    let text = readme();
    let name = |cell: &str| cell.strip_prefix('`').and_then(|c| c.strip_suffix('`')).map(str::to_string);
    let rows: Vec<Vec<String>> = text.lines().filter_map(row).collect();
    // The table is the run of rows whose first cells are names in backticks, around one that is a method.
    let is_name = |r: &Vec<String>| r.first().is_some_and(|c| name(c).is_some());
    let table = rows
        .chunk_by(|a, b| is_name(a) == is_name(b))
        .find(|rows| rows.iter().any(|r| REGISTRY.iter().any(|e| name(&r[0]).as_deref() == Some(e.name))));
    let table = table.unwrap_or_else(|| panic!("README.md has no table of methods"));
    let names: Vec<String> = table.iter().filter_map(|r| name(&r[0])).collect();
    let wanted: Vec<&str> = REGISTRY.iter().map(|e| e.name).collect();
    assert_eq!(names, wanted, "README.md's table of methods and the registry");
    for (row, entry) in table.iter().zip(REGISTRY) {
        assert!(
            row.iter().any(|cell| cell.contains(entry.source)),
            "README.md: {} has another source than the registry's \"{}\": {row:?}",
            entry.name,
            entry.source
        );
    }
}
