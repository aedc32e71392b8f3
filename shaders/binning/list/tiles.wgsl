// Makes the lists of a chunk's tiles from those of its blocks; twin of src/binning/batch.rs.
//
// Three kernels find the length of each tile's list, the index of its first entry, and the entries, in log order.

@group(0) @binding(0) var<uniform> params: BinningParams;
@group(0) @binding(1) var<storage, read> bounds: array<ConeTileBounds>;
@group(0) @binding(2) var<storage, read> blocks: array<u32>;
@group(0) @binding(3) var<storage, read> counts: array<u32>;
@group(0) @binding(4) var<storage, read> cones: array<Cone>;
@group(0) @binding(5) var<storage, read_write> tiles: array<Tile>;
@group(0) @binding(6) var<storage, read_write> entries: array<Entry>;

// The index of the block of a tile in the chunk.
fn block_of(at: vec2<u32>) -> u32 {
    return at.y / BLOCK * BLOCKS + at.x / BLOCK;
}

// The flags of a cone in a tile of the chunk; 0 if the cone or its box does not meet the tile.
fn flags_of(box: ConeTileBounds, at: vec2<u32>) -> u32 {
    if any(at < box.low) || any(at >= box.high) {
        return 0u;
    }
    let cone = cones[box.cone];
    let corner = TILE * (params.chunk + at);
    var flags = meets(cone, corner);
    if any(corner + TILE > params.size) {
        flags &= ~INSIDE;
    }
    if (cone.flags & NO_ECHO) != 0u && (params.flags & ARCS) == 0u {
        flags &= ~ARC;
    }
    return flags;
}

var<workgroup> listed: atomic<u32>;

// A workgroup handles one tile.
@compute @workgroup_size(WORKERS)
fn measure(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let slot = group.x;
    let at = vec2<u32>(slot % CHUNK, slot / CHUNK);
    if lane == 0u {
        atomicStore(&listed, 0u);
    }
    workgroupBarrier();
    var count = 0u;
    for (var segment = 0u; segment < params.segments; segment++) {
        let block = segment * BLOCKS * BLOCKS + block_of(at);
        for (var k = lane; k < counts[block]; k += WORKERS) {
            count += select(0u, 1u, flags_of(bounds[blocks[block * SEGMENT + k]], at) != 0u);
        }
    }
    atomicAdd(&listed, count);
    workgroupBarrier();
    if lane == 0u {
        tiles[slot] = Tile(TILE * (params.chunk + at), vec2<u32>(0u, atomicLoad(&listed)), slot, array<u32, 3>());
    }
}

const TILES_PER_THREAD: u32 = CHUNK * CHUNK / 256u;

var<workgroup> sums: array<u32, 256>;

// One workgroup handles all tiles, with the same number of tiles for each thread.
@compute @workgroup_size(256)
fn place(@builtin(local_invocation_index) lane: u32) {
    var own = 0u;
    for (var k = 0u; k < TILES_PER_THREAD; k++) {
        own += tiles[lane * TILES_PER_THREAD + k].entries.y;
    }
    // Prefix sums over the threads (Hillis & Steele 1986).
    var sum = own;
    for (var step = 1u; step < 256u; step *= 2u) {
        sums[lane] = sum;
        workgroupBarrier();
        if lane >= step {
            sum += sums[lane - step];
        }
        workgroupBarrier();
    }
    var begin_at = sum - own;
    for (var k = 0u; k < TILES_PER_THREAD; k++) {
        let count = tiles[lane * TILES_PER_THREAD + k].entries.y;
        tiles[lane * TILES_PER_THREAD + k].entries = vec2<u32>(begin_at, begin_at + count);
        begin_at += count;
    }
}

// A workgroup handles one tile. It visits WORKERS cones at a time, one for each thread.
@compute @workgroup_size(WORKERS)
fn list(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let slot = group.x;
    let at = vec2<u32>(slot % CHUNK, slot / CHUNK);
    var to = tiles[slot].entries.x;
    begin(lane);
    var turn = 0u;
    for (var segment = 0u; segment < params.segments; segment++) {
        let block = segment * BLOCKS * BLOCKS + block_of(at);
        let count = counts[block];
        for (var k = 0u; k < count; k += WORKERS) {
            var box: ConeTileBounds;
            var flags = 0u;
            if k + lane < count {
                box = bounds[blocks[block * SEGMENT + k + lane]];
                flags = flags_of(box, at);
            }
            let place = rank(lane, turn, flags != 0u);
            turn += 1u;
            if flags != 0u {
                let inside = at - box.low;
                let part = box.part + inside.y * (box.high.x - box.low.x) + inside.x;
                entries[to + place.x] = Entry((box.cone << ENTRY_SHIFT) | (flags & (ARC | INSIDE)), part);
            }
            to += place.y;
        }
    }
}
