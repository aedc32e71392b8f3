//! The session of saved maps, as the page is told: the grid, the sources and their views, the report, the score.

use super::{
    COMBINED, MapLayer, MapSourceView, SIGNED, SavedMap, ScoredMap, Source, SourceKind, ViewContent, class_legend,
    legend, levels, map_pair, scored_map,
};
use crate::grid::{GridSpec, Scale};
use crate::output::tidy;
use crate::view::protocol::{Grid, Json, Legend, MapSession, MapSource, Session, ViewGroup, ViewInfo};
use serde_json::Value;

impl Source {
    /// A map; with `levels` also its error levels.
    pub(super) fn map(name: String, map: SavedMap, levels: bool) -> Source {
        let classes: Vec<String> = serde_json::from_value(map.stored.report["classes"].clone()).unwrap_or_default();
        let about = match map.stored.overview.is_empty() {
            false => "from -1 surely empty to 1 surely occupied",
            true => "from -1 surely empty to 1 surely occupied; made of the layers, as the map was written without it",
        };
        let info = view_info("combined", about, ViewGroup::Main, legend(COMBINED, &[]));
        let mut views = vec![MapSourceView { content: ViewContent::Map(MapLayer::Combined), scale: COMBINED, info }];
        if levels {
            let about = "error level against the truth: 0 right, 9 most dangerous";
            let info = view_info("levels", about, ViewGroup::Main, class_legend(scored_map::legend()));
            let scale = Scale::Classes(scored_map::palette());
            views.push(MapSourceView { content: ViewContent::Levels, scale, info });
        }
        for (k, layer) in map.stored.layers.iter().enumerate() {
            let info = view_info(&layer.name, &layer.about, ViewGroup::Layer, legend(layer.scale, &classes));
            views.push(MapSourceView { content: ViewContent::Map(MapLayer::Layer(k)), scale: layer.scale, info });
        }
        Source { name, kind: SourceKind::Map(Box::new(map)), views }
    }

    /// A truth.
    pub(super) fn truth(name: String) -> Source {
        let info = view_info("class", "what is true: 1 occupied, -1 empty", ViewGroup::Main, legend(SIGNED, &[]));
        let view = MapSourceView { content: ViewContent::Truth, scale: SIGNED, info };
        Source { name, kind: SourceKind::Truth, views: vec![view] }
    }

    /// The source as the session lists it.
    fn info(&self) -> MapSource {
        let (name, views) = (self.name.clone(), self.views.iter().map(|v| v.info.clone()).collect());
        match &self.kind {
            SourceKind::Map(map) => MapSource::Map {
                name,
                method: map.stored.method.clone(),
                path: map.stored.path.display().to_string(),
                aligned: map.alignment.exact,
                views,
            },
            SourceKind::Truth => MapSource::Truth { name, views },
        }
    }
}

fn view_info(name: &str, about: &str, group: ViewGroup, legend: Legend) -> ViewInfo {
    ViewInfo { name: name.into(), about: about.into(), group, legend }
}

/// The session.
pub(super) fn session(name: &str, grid: &GridSpec, sources: &[Source], scored: Option<&ScoredMap>) -> Session {
    let report = sources.first().map_or(Value::Null, |s| match &s.kind {
        SourceKind::Map(map) => map.stored.report.clone(),
        SourceKind::Truth => Value::Null,
    });
    let difference = map_pair(sources).map(|_| {
        let [first, second] = [&sources[0].name, &sources[1].name];
        let about = format!("{second} less {first}; where only one saw a cell the other counts as 0");
        view_info("combined", &about, ViewGroup::Main, legend(SIGNED, &[]))
    });
    Session::Map(Box::new(MapSession {
        name: name.into(),
        version: env!("CARGO_PKG_VERSION").into(),
        grid: Grid {
            x0: tidy(grid.x0()),
            y0: tidy(grid.y0()),
            resolution: grid.resolution,
            width: grid.width,
            height: grid.height,
        },
        levels: levels([grid.width, grid.height]),
        sources: sources.iter().map(Source::info).collect(),
        difference,
        report: Json(report),
        score: scored.map(|s| Json(s.score.clone())),
    }))
}
