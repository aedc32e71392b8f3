//! Reads and checks a world's TOML file: shapes, path and rig. `docs/worlds.md` describes the format.

use super::builder::Builder;
use super::corner::corners;
use super::index::{self, ShapeIndex};
use super::model::World;
use super::path::Obstacles;
use super::rig::Rig;
use super::text::{SourceText, Table};
use crate::{Error, Result};
use sha2::{Digest, Sha256};
use std::path::Path;
use toml::de::DeTable;

/// The keys at the top level.
const KEYS: [&str; 10] = ["name", "classes", "outline", "wall", "box", "circle", "path", "rig", "sensor", "campus"];

impl World {
    /// Reads a world's file.
    ///
    /// # Errors
    /// [`Error::Input`] with the line and a remedy.
    pub fn open(path: &Path) -> Result<World> {
        let example = "give a world's TOML file, or the name of a built-in world, such as room";
        let bytes = std::fs::read(path).map_err(|e| Error::input(path, format!("can't be read: {e}; {example}")))?;
        let text = String::from_utf8(bytes).map_err(|e| {
            let (good, _) = e.as_bytes().split_at(e.utf8_error().valid_up_to());
            let line = good.iter().filter(|b| **b == b'\n').count() as u64 + 1;
            Error::at(path, line, format!("is not UTF-8 text: {example}"))
        })?;
        World::parse(path, &text)
    }

    /// Reads a world from its text; `path` is for messages, and names a world that has no name.
    ///
    /// # Errors
    /// As [`World::open`].
    pub fn parse(path: &Path, source: &str) -> Result<World> {
        let text = SourceText::new(path, source);
        let root = DeTable::parse(source).map_err(|e| {
            text.fail(
                &e.span().unwrap_or_default(),
                format!("not TOML: {} (numbers are written like 0.5, texts in quotes)", e.message()),
            )
        })?;
        let top = Table { text: &text, name: "a world", entries: root.get_ref(), span: 0..0 };
        top.check(&KEYS)?;
        let mut builder = Builder::new(&top)?;
        let path_of_robot = builder.read(&top)?;
        let rig_table = top.tables("rig", "[rig]")?;
        let rig = Rig::read(rig_table.first(), &top.tables("sensor", "[[sensor]]")?)?;
        let bounds = index::bounds(&builder.walls, &builder.arcs);
        let lines: Vec<u64> = builder.wall_lines.iter().chain(&builder.arc_lines).copied().collect();
        let Builder { walls, arcs, closed, classes, .. } = builder;
        let index = ShapeIndex::new(walls, arcs);
        Obstacles { index: &index, closed: &closed, lines: &lines, file: path }.check(&path_of_robot)?;
        let trajectory = path_of_robot.trajectory;
        let span = top.get("path").or(top.get("campus")).map_or(0..0, |v| v.span());
        rig.check(&index, &trajectory).map_err(|what| text.fail(&span, what))?;
        let mut corners = corners(&index);
        corners.sort_by(|a, b| a.at.x.total_cmp(&b.at.x).then(a.at.y.total_cmp(&b.at.y)));
        let sha256 = Sha256::digest(source).iter().map(|byte| format!("{byte:02x}")).collect();
        let name = match top.string("name")? {
            Some(name) => name.get_ref().to_string(),
            None => path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default(),
        };
        Ok(World { name, classes, trajectory, rig, sha256, index, corners, bounds })
    }
}
