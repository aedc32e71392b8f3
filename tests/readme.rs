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

/// What follows each `](` of a text, up to the bracket's end.
fn links(text: &str) -> Vec<&str> {
    text.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect()
}

#[test]
fn its_links_hold_outside_the_repository_too() {
    let (text, root) = (readme(), std::path::Path::new(env!("CARGO_MANIFEST_DIR")));
    let repository = env!("CARGO_PKG_REPOSITORY");
    let raw = repository.replace("https://github.com/", "https://raw.githubusercontent.com/");
    let (blob, raw) = (format!("{repository}/blob/main/"), format!("{raw}/main/"));
    let mut own = 0;
    for link in links(&text) {
        assert!(link.starts_with("https://") || link.starts_with('#'), "README.md: {link} is relative");
        let Some(place) = link.strip_prefix(&blob).or(link.strip_prefix(&raw)) else { continue };
        let (file, heading) = place.split_once('#').unwrap_or((place, ""));
        assert!(root.join(file).exists(), "README.md: {link}: there is no {file}");
        let picture = [".png", ".svg"].iter().any(|e| file.ends_with(e));
        assert_eq!(link.starts_with(&raw), picture, "{link}");
        let slug = |l: &str| l.trim_start_matches('#').trim().to_lowercase().replace(' ', "-").replace('?', "");
        let told = std::fs::read_to_string(root.join(file)).unwrap_or_default();
        let there = told.lines().any(|l| l.starts_with('#') && slug(l) == heading);
        assert!(heading.is_empty() || there, "README.md: {link}: there is no such heading");
        own += 1;
    }
    assert!(own > 15, "{own} links into the repository");
}

#[test]
fn what_the_program_is_made_of_is_packed() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("Cargo.toml")).unwrap();
    let table: toml::Table = text.parse().unwrap();
    let package = &table["package"];
    let include: Vec<&str> = package["include"].as_array().unwrap().iter().filter_map(|v| v.as_str()).collect();
    assert!(include.iter().all(|p| root.join(&p[1..]).exists()), "{include:?}");
    let packed = |path: &std::path::Path| include.iter().any(|p| path.starts_with(root.join(&p[1..])));
    // every file that the sources build in
    let (mut open, mut built_in) = (vec![root.join("src")], 0);
    while let Some(place) = open.pop() {
        if place.is_dir() {
            open.extend(std::fs::read_dir(&place).unwrap().map(|e| e.unwrap().path()));
            continue;
        }
        let text = std::fs::read_to_string(&place).unwrap();
        for part in text.split("include_str!(\"").chain(text.split("include_bytes!(\"")).skip(1) {
            let named = part.split('"').next().unwrap();
            let path = place.parent().unwrap().join(named);
            if named.starts_with("..") && path.exists() {
                assert!(packed(&path.canonicalize().unwrap()), "{}: {named} isn't packed", place.display());
                built_in += 1;
            }
        }
    }
    assert!(built_in > 20, "{built_in} files are built in");
    assert!(include.contains(&"/worlds"));
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
