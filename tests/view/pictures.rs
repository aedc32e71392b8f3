//! Tiles as a page sees them, and what they are held against.

use echogrid::view::map::MapView;
use echogrid::view::{Request, Response, View};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use zarrs::array::Array;
use zarrs::filesystem::FilesystemStore;

/// A picture: its extent, its palette entries with the top row first, its palette.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    pub extent: [usize; 2],
    pub entries: Vec<u8>,
    pub palette: Vec<u8>,
}

impl Picture {
    /// The entry of a pixel, rows from the bottom.
    pub fn at(&self, column: usize, row: usize) -> u8 {
        self.entries[(self.extent[1] - 1 - row) * self.extent[0] + column]
    }
}

/// Decodes an indexed PNG.
pub fn decode(bytes: &[u8]) -> Picture {
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::IDENTITY);
    let mut reader = decoder.read_info().unwrap();
    let mut entries = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut entries).unwrap();
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Indexed, png::BitDepth::Eight));
    let palette = reader.info().palette.as_ref().unwrap().to_vec();
    Picture { extent: [info.width as usize, info.height as usize], entries, palette }
}

/// Asks a view; the query is `key=value&…`.
pub fn ask(view: &dyn View, path: &str, query: &str) -> echogrid::Result<Response> {
    let pairs = query.split('&').filter_map(|p| p.split_once('=')).map(|(k, v)| (k.to_string(), v.to_string()));
    let query: BTreeMap<String, String> = pairs.collect();
    view.respond(&Request { post: false, path, query: &query, body: &[] })
}

#[track_caller]
pub fn json(view: &dyn View, path: &str, query: &str) -> Value {
    match ask(view, path, query) {
        Ok(Response::Json(value)) => value,
        other => panic!("{path} {query}: {other:?}"),
    }
}

/// A tile; `None` where nothing was reached.
#[track_caller]
pub fn tile(view: &dyn View, source: &str, name: &str, [level, column, row]: [usize; 3]) -> Option<Picture> {
    let query = format!("source={source}&view={name}&level={level}&column={column}&row={row}&v=1");
    match ask(view, "api/tile", &query) {
        Ok(Response::Bytes("image/png", bytes)) => Some(decode(&bytes)),
        Ok(Response::NoContent) => None,
        other => panic!("{query}: {other:?}"),
    }
}

/// All of a level: palette entries, rows from the bottom, and its extent. Each tile has the extent that it should.
#[track_caller]
pub fn level(view: &dyn View, source: &str, name: &str, level: usize) -> ([usize; 2], Vec<u8>) {
    let session = json(view, "api/session", "");
    let side = |key: &str| (session["grid"][key].as_u64().unwrap() as usize).div_ceil(1 << level);
    let [width, height] = ["width", "height"].map(side);
    let mut all = vec![0; width * height];
    for (row, column) in (0..height.div_ceil(256)).flat_map(|r| (0..width.div_ceil(256)).map(move |c| (r, c))) {
        let Some(picture) = tile(view, source, name, [level, column, row]) else { continue };
        assert_eq!(picture.extent, [256.min(width - column * 256), 256.min(height - row * 256)]);
        assert!(picture.entries.iter().any(|e| *e != 0), "a tile of nothing is none");
        for r in 0..picture.extent[1] {
            for c in 0..picture.extent[0] {
                all[(row * 256 + r) * width + column * 256 + c] = picture.at(c, r);
            }
        }
    }
    ([width, height], all)
}

/// A level of the overview that is stored with a map, rows from the bottom.
pub fn stored(folder: &Path, level: usize) -> Vec<u8> {
    let store = Arc::new(FilesystemStore::new(folder.join("map.zarr")).unwrap());
    let array = Array::open(store, &format!("/overview/{level}")).unwrap();
    array.retrieve_array_subset(&array.subset_all()).unwrap()
}

/// A map and nothing else, opened.
pub fn open(folder: &Path) -> MapView {
    MapView::open(folder, &Default::default()).unwrap()
}
