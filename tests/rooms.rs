//! The rooms of `src/`: each module that `src/lib.rs` declares uses only modules declared before it, and no files name each
//! other in a circle. Paths that begin with `crate::` or `super::` are read as text; what a test module uses doesn't count.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Rooms at most; `support` (errors and the like) is none.
const MOST: usize = 16;

/// Source without comments and test modules.
fn code(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap();
    let text = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Every `.rs` file below a folder.
fn files(folder: &Path, all: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            files(&path, all);
        } else if path.extension().is_some_and(|e| e == "rs") {
            all.push(path);
        }
    }
}

/// The paths of a use tree, such as `a::{b, c::{d}}`: `a::b`, `a::c::d`. Reads up to the tree's end.
fn tree(text: &str) -> Vec<String> {
    let name = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let end = text.find(|c| !name(c)).unwrap_or(text.len());
    let (head, rest) = text.split_at(end);
    if !((head.is_empty() || head.ends_with("::")) && rest.starts_with('{')) {
        return vec![head.trim_end_matches(':').to_string()];
    }
    let (mut depth, mut from, mut found) = (0, 1, Vec::new());
    for (at, c) in rest.char_indices() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if (c == ',' && depth == 1) || depth == 0 {
            let inner = rest[from..at].trim();
            found.extend(tree(inner).into_iter().filter(|p| !p.is_empty()).map(|p| format!("{head}{p}")));
            from = at + 1;
        }
        if depth == 0 {
            break;
        }
    }
    found
}

/// The paths in a module's code, from the crate's root.
fn paths(module: &[String], code: &str) -> Vec<String> {
    let mut all = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        if !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '$') {
            all.extend(tree(&code[at + "crate::".len()..]));
        }
    }
    for (at, _) in code.match_indices("super::") {
        // The first `super` of a path alone; more of them go further up.
        if code[..at].ends_with("super::") || code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_') {
            continue;
        }
        let (mut rest, mut up) = (&code[at..], 0);
        while let Some(after) = rest.strip_prefix("super::") {
            (rest, up) = (after, up + 1);
        }
        let Some(base) = module.len().checked_sub(up) else { continue };
        all.extend(tree(rest).into_iter().map(|p| [&module[..base], &[p]].concat().join("::")));
    }
    all
}

/// The modules that name each other in a circle: the strongly connected ones of more than one.
fn circles(uses: &BTreeMap<String, BTreeSet<String>>) -> Vec<Vec<String>> {
    let reach = |from: &str| {
        let (mut seen, mut stack) = (BTreeSet::new(), vec![from.to_string()]);
        while let Some(at) = stack.pop() {
            for next in uses.get(&at).into_iter().flatten() {
                if seen.insert(next.clone()) {
                    stack.push(next.clone());
                }
            }
        }
        seen
    };
    let reached: BTreeMap<&String, BTreeSet<String>> = uses.keys().map(|m| (m, reach(m))).collect();
    let mut found = BTreeSet::new();
    for (module, all) in &reached {
        if all.contains(*module) {
            let circle: Vec<String> =
                all.iter().filter(|other| reached.get(other).is_some_and(|r| r.contains(*module))).cloned().collect();
            found.insert(circle);
        }
    }
    found.into_iter().collect()
}

#[test]
fn a_room_uses_only_rooms_before_it_and_files_form_no_circle() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let lib = code(&src.join("lib.rs"));
    let declared = |line: &str| {
        let line = line.trim().strip_prefix("pub ").unwrap_or(line.trim());
        line.strip_prefix("mod ").and_then(|l| l.strip_suffix(';')).map(str::to_string)
    };
    let rooms: Vec<String> = lib.lines().filter_map(declared).collect();
    assert!(rooms.len() > 10, "src/lib.rs declares {rooms:?}");
    assert!(rooms.iter().filter(|r| *r != "support").count() <= MOST, "more than {MOST} rooms: {rooms:?}");

    let mut all = Vec::new();
    files(&src, &mut all);
    // Each module by its path in the crate.
    let module = |file: &PathBuf| {
        let path = file.strip_prefix(&src).unwrap().with_extension("");
        let mut parts: Vec<String> = path.iter().map(|p| p.to_string_lossy().into_owned()).collect();
        parts.pop_if(|last| last == "mod");
        parts
    };
    let modules: BTreeMap<String, PathBuf> = all.iter().map(|f| (module(f).join("::"), f.clone())).collect();
    let target = |path: &str| {
        let parts: Vec<&str> = path.split("::").collect();
        (1..=parts.len()).rev().map(|n| parts[..n].join("::")).find(|m| modules.contains_key(m))
    };
    let place = |room: &str| rooms.iter().position(|r| r == room);
    let (mut back, mut uses) = (Vec::new(), BTreeMap::<String, BTreeSet<String>>::new());
    for file in &all {
        let own = module(file);
        if own == ["lib"] || own == ["main"] || own.iter().any(|part| part == "tests") {
            continue;
        }
        let name = own.join("::");
        for path in paths(&own, &code(file)) {
            let (from, to) = (place(&own[0]), path.split("::").next().and_then(place));
            if let (Some(from), Some(to)) = (from, to)
                && to > from
            {
                back.push(format!("{name} uses {path}: room {} stands before {}", rooms[from], rooms[to]));
            }
            if let Some(target) = target(&path).filter(|t| *t != name) {
                uses.entry(name.clone()).or_default().insert(target);
            }
        }
    }
    assert!(back.is_empty(), "arrows back:\n{}", back.join("\n"));
    let circles: Vec<String> = circles(&uses).iter().map(|c| c.join(", ")).collect();
    assert!(circles.is_empty(), "circles:\n{}", circles.join("\n"));
    assert!(uses.values().map(BTreeSet::len).sum::<usize>() > 500, "the paths were not read");
}

#[test]
fn a_use_tree_is_read_whole() {
    let read = tree("a::{self, b::{C, D}, e as f};");
    assert_eq!(read, ["a::self", "a::b::C", "a::b::D", "a::e"]);
    assert_eq!(tree("kernels::Backend;"), ["kernels::Backend"]);
    assert_eq!(tree("{Error, kernels::{Backend, cpu}};"), ["Error", "kernels::Backend", "kernels::cpu"]);
    let module: Vec<String> = ["log", "carmen"].map(String::from).into();
    assert_eq!(paths(&module, "use super::codes::Code; super::super::x::y()"), ["log::codes::Code", "x::y"]);
    let uses = [("a", "b"), ("b", "c"), ("c", "b")].map(|(a, b)| (a.to_string(), BTreeSet::from([b.to_string()])));
    assert_eq!(circles(&uses.into()), [["b", "c"]]);
}

#[test]
fn the_functions_on_a_readings_way_are_where_architecture_says() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("ARCHITECTURE.md")).unwrap();
    let way = text.split("## One reading").nth(1).unwrap().split("\n## ").next().unwrap();
    let mut found = 0;
    for line in way.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit())) {
        let path = line.split('`').nth(1).unwrap();
        let (module, function) = path.rsplit_once("::").unwrap();
        let file = root.join("src").join(module.replace("::", "/"));
        let source = [file.with_extension("rs"), file.join("mod.rs")];
        let source = source.iter().find(|f| f.exists()).unwrap_or_else(|| panic!("{path}: there is no such file"));
        let defined = ["(", "<"].map(|after| format!("fn {function}{after}"));
        assert!(defined.iter().any(|d| code(source).contains(d)), "{path}: {} has no such function", source.display());
        found += 1;
    }
    assert!((1..=9).contains(&found), "{found} functions");
}
