// Updates each cell with the nearest beam of each of its nearest poses, in log order; twin of src/method/driver/scan.rs.
//
// A workgroup is a tile, a thread a cell, which holds its state in registers. The list has every pose that may be among the nearest.

const EDGE: u32 = 1024u;
const TILE_CELLS: u32 = 256u;
// A number larger than any squared distance.
const FAR: vec2<u32> = vec2<u32>(0xffffffffu, 0x7fffffffu);

// The n-th smallest squared distance of a cell from the poses. Of the poses at that distance the first `ties` are among the n nearest.
struct Nth {
    square: vec2<u32>,
    ties: u32,
}

fn nth(tile: Tile, centre: vec2<i32>) -> Nth {
    if NEIGHBOURS == 0u {
        return Nth(FAR, 0u);
    }
    var held: array<vec2<u32>, HELD>;
    for (var j = 0u; j < HELD; j++) {
        held[j] = FAR;
    }
    for (var k = tile.entries.x; k < tile.entries.y; k++) {
        let v = centre - scans[entries[k].cone >> ENTRY_SHIFT].pose;
        var value = wide_dot(v, v);
        if wide_less(value, held[HELD - 1u]) {
            for (var j = 0u; j < HELD; j++) {
                let smaller = wide_less(value, held[j]);
                let other = select(value, held[j], smaller);
                held[j] = select(held[j], value, smaller);
                value = other;
            }
        }
    }
    let last = held[HELD - 1u];
    var ties = 0u;
    for (var j = 0u; j < HELD; j++) {
        ties += select(0u, 1u, all(held[j] == last));
    }
    return Nth(last, ties);
}

@compute @workgroup_size(256)
fn fuse(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let tile = tiles[group.x];
    let at = tile.corner + vec2<u32>(lane % TILE, lane / TILE);
    if any(at >= frame.size) {
        return;
    }
    let centre = vec2<i32>(centres[at.x % EDGE], centres[EDGE + at.y % EDGE]);
    let farthest = wide_mul(frame.limits.x, frame.limits.x);
    let first = tile.slot * PLANES * TILE_CELLS + lane;
    var cell: Cell;
    for (var n = 0u; n < PLANES - 3u; n++) {
        cell.alpha[n] = state[first + (3u + n) * TILE_CELLS];
    }
    let last = nth(tile, centre);
    var ties = last.ties;
    for (var k = tile.entries.x; k < tile.entries.y; k++) {
        let entry = entries[k];
        let scan = scans[entry.cone >> ENTRY_SHIFT];
        let v = centre - scan.pose;
        let square = wide_dot(v, v);
        let tied = all(square == last.square) && ties > 0u;
        ties -= select(0u, 1u, tied);
        let taken = wide_less(square, last.square) || tied;
        if taken && wide_less(square, farthest) && any(square != vec2<u32>(0u)) {
            let found = place(scan.first, v, entry.slot & 0xffffu, entry.slot >> 16u);
            let beam = beams[scan.first + select(found, 0u, found == scan.count)];
            update(scan.number, beam, v, square, &cell);
        }
    }
    state[first] += cell.interior;
    state[first + TILE_CELLS] += cell.arc;
    state[first + 2u * TILE_CELLS] += cell.marks;
    for (var n = 0u; n < PLANES - 3u; n++) {
        state[first + (3u + n) * TILE_CELLS] = cell.alpha[n];
    }
}
