// The bytes that both backends read; twin of src/layout.rs.

const CELL: i32 = 32;
const DIRECTION: i32 = 8192;
const TILE: u32 = 16u;

const NO_ECHO: u32 = 1u;
const LASER: u32 = 2u;
const HALF_OPEN: u32 = 4u;
const WIDE: u32 = 8u;
const BROAD: u32 = 16u;

const ARC: u32 = 1u;
const INSIDE: u32 = 2u;
const ENTRY_SHIFT: u32 = 2u;

const FREE: u32 = 1u;
const OCCUPY: u32 = 2u;
const COUNT: u32 = 4u;

struct Frame {
    size: vec2<u32>,
    mode: u32,
    scale: f32,
    constants: array<vec4<f32>, 2>,
}

struct Cone {
    sensor: vec2<i32>,
    reach: vec2<i32>,
    axis: vec2<i32>,
    left: vec2<i32>,
    right: vec2<i32>,
    flags: u32,
    index: u32,
    shape: vec4<f32>,
    profile: vec4<f32>,
}

struct Tile {
    corner: vec2<u32>,
    entries: vec2<u32>,
    slot: u32,
    spare: array<u32, 3>,
}

struct Entry {
    cone: u32,
    slot: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> cones: array<Cone>;
@group(0) @binding(2) var<storage, read> tiles: array<Tile>;
@group(0) @binding(3) var<storage, read> entries: array<Entry>;
// A chunk's cells, tile by tile, plane by plane, four cells of a row in a vector.
@group(0) @binding(4) var<storage, read_write> state: array<vec4<u32>>;
// Binding 5 is the drivers': parts of the sums over each reading's arc, or its counts.
// What a pass hands to the next, for each reading.
@group(0) @binding(6) var<storage, read_write> shares: array<vec4<u32>>;
// Where each reading's parts begin.
@group(0) @binding(7) var<storage, read> first_part: array<u32>;
