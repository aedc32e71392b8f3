// Updates a tile's cells with its list of readings, in log order; twin of src/kernels/cpu/walk.rs (fuse).
//
// A workgroup is a tile; a thread owns four cells of a row and holds their state in registers, so the map is read once and
// written once a batch. Bounds: groups are the chunk's listed tiles, entries those of the tile's list.

@compute @workgroup_size(64)
fn fuse(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let tile = tiles[group.x];
    let cell = tile.corner + vec2<u32>((lane % 4u) * 4u, lane / 4u);
    let centre = CELL * vec2<i32>(cell) + vec2<i32>(CELL / 2);
    let columns = select(0, i32(frame.size.x) - i32(cell.x), cell.y < frame.size.y);
    let at = tile.slot * PLANES * 64u + lane;
    let one = select(0u, 1u, (frame.mode & COUNT) != 0u);
    var interior = vec4<u32>(0u);
    var arc = vec4<u32>(0u);
    var cells = load(at + 128u);
    for (var k = tile.entries.x; k < tile.entries.y; k++) {
        let entry = entries[k];
        let cone = cones[entry.cone >> ENTRY_SHIFT];
        var row = member_row(cone, centre - cone.sensor);
        clip(&row, columns);
        if (cone.flags & NO_ECHO) != 0u {
            row.arc = vec4<bool>(false);
        }
        if any(row.interior | row.arc) {
            interior += select(vec4<u32>(0u), vec4<u32>(one), row.interior);
            arc += select(vec4<u32>(0u), vec4<u32>(one), row.arc);
            fuse_cells(cone, row, shares[cone.index], &cells);
        }
        if (k - tile.entries.x) % 16u == 15u {
            settle(&cells);
        }
    }
    settle(&cells);
    state[at] += interior;
    state[at + 64u] += arc;
    store(cells, at + 128u);
}
