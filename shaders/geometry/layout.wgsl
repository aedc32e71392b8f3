// The records and constants that both backends read; twin of src/geometry/layout.rs.

const CELL: i32 = 32;
const DIRECTION: i32 = 8192;
const TILE: u32 = 16u;
const CHUNK: u32 = 64u;
const BLOCK: u32 = 4u;
const BLOCKS: u32 = 16u;
const SEGMENT: u32 = 4096u;

const NO_ECHO: u32 = 1u;
const NARROW_BEAM: u32 = 2u;
const HALF_OPEN: u32 = 4u;
const WIDE: u32 = 8u;
const BROAD: u32 = 16u;

const ARC: u32 = 1u;
const INSIDE: u32 = 2u;
const ENTRY_SHIFT: u32 = 2u;

const UNIT: i32 = 33554432;
const IDLE: u32 = 256u;
const YIELD: u32 = 512u;
const BEAM_SHIFT: u32 = 16u;

const FAN: u32 = 1u;
const FULL: u32 = 16u;
const LINES: u32 = 256u;
const ROUTINE: u32 = 1024u;

const FREE_LIMIT: u32 = 1u;
const ARC_LIMIT: u32 = 2u;

const AXIS: u32 = 1u;
const ARCS: u32 = 2u;

const FREE: u32 = 1u;
const OCCUPY: u32 = 2u;
const COUNT: u32 = 4u;

struct Frame {
    size: vec2<u32>,
    mode: u32,
    scale: f32,
    constants: array<vec4<f32>, 2>,
    limits: vec4<i32>,
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

struct ConeTileBounds {
    cone: u32,
    part: u32,
    low: vec2<u32>,
    high: vec2<u32>,
}

struct BinningParams {
    chunk: vec2<u32>,
    size: vec2<u32>,
    cones: u32,
    segments: u32,
    flags: u32,
    pad: u32,
}

struct Scan {
    pose: vec2<i32>,
    first: u32,
    count: u32,
    number: u32,
    pad: array<u32, 3>,
}

struct Beam {
    bound: vec2<i32>,
    ray: array<vec2<i32>, 2>,
    range: i32,
    id: u32,
}

struct Shapes {
    fans: array<vec2<u32>, 4>,
    lines: array<vec2<u32>, 2>,
    weights: vec4<f32>,
    number: u32,
    flags: u32,
    room: vec2<u32>,
}

struct Entry {
    cone: u32,
    slot: u32,
}
