//! A folder to run the command in, and what came of a run.

#[path = "../data/mod.rs"]
mod data;

use assert_cmd::Command;
#[allow(unused_imports, reason = "not all that share this file need a real log")]
pub use data::data;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A log of one sonar: two hits, two missing echoes, one reading rejected for each reason.
pub const SMALL: &str = r#"{"echogrid_log":1,"sensors":[{"id":"front","r_min":0.2,"r_max":4,"hit_range":3,"no_echo_range":1}]}
{"t":0,"scan":0,"sensor":0,"px":0,"py":0,"ph":0,"z":1.5}
{"t":0,"scan":1,"sensor":0,"px":0.5,"py":0,"ph":0.5,"z":2}
{"t":0,"scan":2,"sensor":0,"px":1,"py":0,"ph":1,"z":null}
{"t":0,"scan":3,"sensor":0,"px":1,"py":0,"ph":1,"z":0.1}
{"t":0,"scan":3,"sensor":0,"px":1,"py":0,"ph":1,"z":-1}
{"t":0,"scan":3,"sensor":0,"px":1,"py":0,"ph":1,"z":"NaN"}
{"t":0,"scan":3,"sensor":0,"px":1,"py":0,"ph":1,"z":3.5}
{"t":0,"scan":3,"sensor":0,"px":1,"py":0,"ph":1,"z":"inf"}
"#;

/// The header of a log of one sonar of which nothing is known.
pub const HEADER: &str = "{\"echogrid_log\":1,\"sensors\":[{\"id\":\"front\"}]}\n";

/// A reading of that log at (x, 0).
pub fn line(x: &str, z: &str) -> String {
    format!("{{\"scan\":0,\"px\":{x},\"py\":0,\"ph\":0,\"z\":{z}}}\n")
}

/// A temporary folder in which the command runs.
pub struct Place {
    folder: tempfile::TempDir,
}

/// What a run came to. In both texts the folder's own path is written as `HERE`.
#[derive(Debug)]
pub struct Ran {
    pub code: i32,
    pub out: String,
    pub err: String,
}

impl Place {
    /// With the small log as `log.jsonl`.
    pub fn new() -> Place {
        let place = Place { folder: tempfile::tempdir().unwrap() };
        place.write("log.jsonl", SMALL);
        std::fs::create_dir(place.path("run")).unwrap();
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().canonicalize().unwrap().join(name)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    /// The command, to be run here.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::cargo_bin("echogrid").unwrap();
        // Mesa complains on standard error without a folder of its own.
        command.args(arguments).current_dir(self.folder.path()).env("XDG_RUNTIME_DIR", self.path("run"));
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Ran {
        self.finish(&mut self.command(arguments))
    }

    /// Runs it with the adapters hidden from the Vulkan loader.
    #[cfg(target_os = "linux")]
    pub fn run_without_adapter(&self, arguments: &[&str], required: bool) -> Ran {
        let mut command = self.command(arguments);
        for name in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
            command.env(name, self.path("no-driver.json"));
        }
        command.env("ECHOGRID_REQUIRE_GPU", if required { "1" } else { "0" });
        self.finish(&mut command)
    }

    pub fn finish(&self, command: &mut Command) -> Ran {
        let output = command.output().unwrap();
        let here = self.path("").display().to_string();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap().replace(here.trim_end_matches('/'), "HERE");
        Ran { code: output.status.code().unwrap(), out: text(output.stdout), err: text(output.stderr) }
    }

    /// Runs it and expects an error: this exit code, this whole message, nothing on standard output, and not a name more
    /// or less in the folder.
    #[track_caller]
    pub fn refuses(&self, arguments: &[&str], code: i32, message: &str) {
        let before = self.names("");
        let ran = self.run(arguments);
        assert_eq!((ran.code, ran.err.trim_end()), (code, message), "{arguments:?}: {ran:?}");
        assert_eq!(ran.out, "", "{arguments:?}");
        assert_eq!(self.names(""), before, "{arguments:?} left something behind");
    }

    /// Runs it and expects it to succeed.
    #[track_caller]
    pub fn does(&self, arguments: &[&str]) -> Ran {
        let ran = self.run(arguments);
        assert_eq!(ran.code, 0, "{arguments:?}: {ran:?}");
        ran
    }

    /// Maps the small log into `folder` on the CPU.
    #[track_caller]
    pub fn map(&self, folder: &str, more: &[&str]) -> Ran {
        self.does(&[&["map", "log.jsonl", "-o", folder, "--backend", "cpu"][..], more].concat())
    }

    /// The names in a folder, sorted.
    pub fn names(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(folder)).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Every file below a folder, by its path in it.
    pub fn files(&self, folder: &str) -> BTreeMap<String, Vec<u8>> {
        let folder = self.path(folder);
        let mut all = BTreeMap::new();
        let mut open = vec![folder.clone()];
        while let Some(next) = open.pop() {
            for entry in std::fs::read_dir(next).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    open.push(path);
                } else {
                    let name = path.strip_prefix(&folder).unwrap().display().to_string();
                    all.insert(name, std::fs::read(&path).unwrap());
                }
            }
        }
        all
    }

    /// A map's report.
    pub fn report(&self, folder: &str) -> Value {
        serde_json::from_slice(&std::fs::read(self.path(folder).join("report.json")).unwrap()).unwrap()
    }
}

impl Ran {
    /// Standard output as JSON.
    #[track_caller]
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e}: {self:?}"))
    }
}

/// The keys of an object, sorted.
pub fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<&str> = value.as_object().unwrap().keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}
