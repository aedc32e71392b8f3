//! The worlds that come with the program, by name: no clone is needed to simulate one or to score against it.

use super::World;
use crate::{Error, Result};
use std::path::Path;

/// A world that is built in.
#[derive(Debug, Clone, Copy)]
pub struct Shipped {
    /// Its name.
    pub name: &'static str,
    /// Its TOML file.
    pub text: &'static str,
}

macro_rules! shipped {
    ($($name:literal),*) => {
        [$(Shipped { name: $name, text: include_str!(concat!("../../worlds/", $name, ".toml")) }),*]
    };
}

/// All of them, the smallest first.
pub const SHIPPED: [Shipped; 6] = shipped!["room", "turned", "bend", "cartons", "floor", "campus"];

impl Shipped {
    /// The one of a name.
    pub fn named(name: &Path) -> Option<&'static Shipped> {
        SHIPPED.iter().find(|s| Path::new(s.name) == name)
    }

    /// What it is, from the comment at its file's head.
    pub fn about(&self) -> String {
        let comment = self.text.lines().map_while(|l| l.strip_prefix('#')).map(str::trim);
        comment.collect::<Vec<_>>().join(" ")
    }

    /// What to tell a user of a name that is a file's or a folder's as well: the built-in world is meant.
    pub fn beside_file(name: &Path) -> Option<String> {
        let shipped = Shipped::named(name).filter(|_| name.exists())?;
        Some(format!("{0} is the built-in world; for what is called so in this folder write ./{0}", shipped.name))
    }
}

impl World {
    /// The world of a name that is built in, or of a file. A built-in name is never a file: `./room` is one.
    ///
    /// # Errors
    /// [`Error::Input`] as for [`World::open`], with the names that there are where there is no such file.
    pub fn find(name: &Path) -> Result<World> {
        match Shipped::named(name) {
            Some(shipped) => World::parse(Path::new(&format!("{} (built in)", shipped.name)), shipped.text),
            None if !name.exists() => Err(Error::input(name, format!("there is no such file; {}", meant(name)))),
            None => World::open(name),
        }
    }
}

/// Which built-in world was meant, or which there are.
pub(crate) fn meant(name: &Path) -> String {
    let stem = name.file_stem().map(|s| s.to_string_lossy().to_lowercase()).unwrap_or_default();
    let near = |s: &&Shipped| strsim::jaro_winkler(&stem, s.name);
    match SHIPPED.iter().max_by(|a, b| near(a).total_cmp(&near(b))).filter(|s| near(s) > 0.75) {
        Some(best) => format!("did you mean \"{}\", a built-in world?", best.name),
        None => format!("the built-in worlds are {}", SHIPPED.map(|s| s.name).join(", ")),
    }
}
