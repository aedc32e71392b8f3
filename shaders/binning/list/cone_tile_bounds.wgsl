// Sorts cones into blocks of tiles by their boxes, in log order; twin of src/binning/batch/cone_tile_bounds.rs.
//
// Each segment of a chunk's cones has a list for each block. A workgroup handles one block and one segment. It visits WORKERS
// cones at a time, one for each thread.

@group(0) @binding(0) var<uniform> params: BinningParams;
@group(0) @binding(1) var<storage, read> bounds: array<ConeTileBounds>;
@group(0) @binding(2) var<storage, read_write> blocks: array<u32>;
@group(0) @binding(3) var<storage, read_write> counts: array<u32>;

@compute @workgroup_size(WORKERS)
fn sort_into_blocks(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let low = BLOCK * vec2<u32>(group.x % BLOCKS, group.x / BLOCKS);
    let high = low + BLOCK;
    let block = group.y * BLOCKS * BLOCKS + group.x;
    begin(lane);
    var count = 0u;
    for (var turn = 0u; turn < SEGMENT / WORKERS; turn++) {
        let k = group.y * SEGMENT + turn * WORKERS + lane;
        var meets = false;
        if k < params.cones {
            let box = bounds[k];
            meets = all(box.low < high) && all(box.high > low);
        }
        let place = rank(lane, turn, meets);
        if meets {
            blocks[block * SEGMENT + count + place.x] = k;
        }
        count += place.y;
    }
    if lane == 0u {
        counts[block] = count;
    }
}
