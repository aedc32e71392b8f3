//! What a page is told of saved maps when it opens: the grid, the sources and their views, the report, the score.

use super::{COMBINED, Kind, MapView, SIGNED, Saved, Shape, Show, Source, What, classed, legend, levels, scored};
use crate::grid::{GridSpec, Scale};
use crate::output::tidy;
use serde_json::{Value, json};

impl Source {
    /// A map. `levels`: its error levels are shown too.
    pub(super) fn map(name: String, map: Saved, levels: bool) -> Source {
        let classes: Vec<String> = serde_json::from_value(map.stored.report["classes"].clone()).unwrap_or_default();
        let about = match map.stored.overview.is_empty() {
            false => "from -1 surely empty to 1 surely occupied",
            true => "from -1 surely empty to 1 surely occupied; made of the layers, as the map was written without it",
        };
        let key = legend(COMBINED, &[]);
        let mut views = vec![shape("combined", Show::Map(What::Combined), COMBINED, about, "main", key)];
        if levels {
            let about = "error level against the truth: 0 right, 9 most dangerous";
            let (scale, key) = (Scale::Classes(scored::palette()), classed(scored::legend()));
            views.push(shape("levels", Show::Levels, scale, about, "main", key));
        }
        for (k, layer) in map.stored.layers.iter().enumerate() {
            let key = legend(layer.scale, &classes);
            let show = Show::Map(What::Layer(k));
            views.push(shape(&layer.name, show, layer.scale, &layer.about, "layer", key));
        }
        Source { name, kind: Kind::Map(Box::new(map)), views }
    }

    /// The truth.
    pub(super) fn truth(name: String) -> Source {
        let about = "what is true: 1 occupied, -1 empty";
        let view = shape("class", Show::Truth, SIGNED, about, "main", legend(SIGNED, &[]));
        Source { name, kind: Kind::Truth, views: vec![view] }
    }

    fn listed(&self) -> Value {
        let views: Vec<&Value> = self.views.iter().map(|v| &v.listed).collect();
        match &self.kind {
            Kind::Map(map) => json!({
                "name": self.name, "kind": "map", "method": map.stored.method, "path": map.stored.path.display().to_string(),
                "aligned": map.laid.exact, "views": views,
            }),
            Kind::Truth => json!({"name": self.name, "kind": "truth", "views": views}),
        }
    }
}

fn shape(name: &str, show: Show, scale: Scale, about: &str, group: &str, key: Value) -> Shape {
    let listed = json!({"name": name, "about": about, "group": group, "legend": key});
    Shape { name: name.into(), show, scale, listed }
}

impl MapView {
    /// The session.
    pub(super) fn describe(&self, name: &str) -> Value {
        let GridSpec { resolution, width, height, .. } = self.grid;
        let report = self.sources.first().map(|s| match &s.kind {
            Kind::Map(map) => map.stored.report.clone(),
            Kind::Truth => Value::Null,
        });
        let names: Vec<&str> = self.sources.iter().map(|s| s.name.as_str()).collect();
        let difference = self.pair().map(|_| {
            let about = format!("{} less {}; where only one saw a cell the other counts as 0", names[1], names[0]);
            shape("combined", Show::Map(What::Combined), SIGNED, &about, "main", legend(SIGNED, &[])).listed
        });
        let mut session = json!({
            "mode": "map",
            "name": name,
            "version": env!("CARGO_PKG_VERSION"),
            "grid": {
                "x0": tidy(self.grid.x0()), "y0": tidy(self.grid.y0()), "resolution": resolution,
                "width": width, "height": height,
            },
            "levels": levels([width, height]),
            "sources": self.sources.iter().map(Source::listed).collect::<Vec<Value>>(),
            "difference": difference,
            "report": report,
        });
        if let Some(scored) = &self.scored {
            session["score"] = scored.numbers.clone();
        }
        session
    }
}
