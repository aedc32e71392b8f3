//! The built-in worlds, by name: no checkout is needed to simulate one or to score against it.

use super::model::World;
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
    /// The built-in world of a name.
    pub fn named(name: &Path) -> Option<&'static Shipped> {
        SHIPPED.iter().find(|s| Path::new(s.name) == name)
    }

    /// Its description, from the comment at the head of its file.
    pub fn about(&self) -> String {
        let comment = self.text.lines().map_while(|l| l.strip_prefix('#')).map(str::trim);
        comment.collect::<Vec<_>>().join(" ")
    }

    /// A note for the user where a file or a folder has the name of a built-in world: the built-in world is used.
    pub fn beside_file(name: &Path) -> Option<String> {
        let shipped = Shipped::named(name).filter(|_| name.exists())?;
        Some(format!("{0} is the built-in world; for what is called so in this folder write ./{0}", shipped.name))
    }
}

impl World {
    /// The built-in world of a name, or the world of a file. A file with a built-in name is written `./room`.
    ///
    /// # Errors
    /// [`Error::Input`] as for [`World::open`]; where there is no such file, with the names of the built-in worlds.
    pub fn find(name: &Path) -> Result<World> {
        match Shipped::named(name) {
            Some(shipped) => World::parse(Path::new(&format!("{} (built in)", shipped.name)), shipped.text),
            None if !name.exists() => Err(Error::input(name, format!("there is no such file; {}", meant(name)))),
            None => World::open(name),
        }
    }
}

/// The built-in world with the most similar name, or the list of all.
pub(crate) fn meant(name: &Path) -> String {
    let stem = name.file_stem().map(|s| s.to_string_lossy().to_lowercase()).unwrap_or_default();
    let near = |s: &&Shipped| strsim::jaro_winkler(&stem, s.name);
    match SHIPPED.iter().max_by(|a, b| near(a).total_cmp(&near(b))).filter(|s| near(s) > 0.75) {
        Some(best) => format!("did you mean \"{}\", a built-in world?", best.name),
        None => format!("the built-in worlds are {}", SHIPPED.map(|s| s.name).join(", ")),
    }
}
