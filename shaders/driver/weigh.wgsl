// Each thread's part of each reading's evidence on its arc; twin of src/kernels/cpu/walk.rs (weigh).
//
// A kernel of its own because the update needs the whole sum. The threads of a tile never meet: each stores what its four
// cells come to, and sum.wgsl adds them up in one order.

@group(0) @binding(5) var<storage, read_write> parts: array<f32>;

@compute @workgroup_size(64)
fn weigh(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let tile = tiles[group.x];
    let cell = tile.corner + vec2<u32>((lane % 4u) * 4u, lane / 4u);
    let centre = CELL * vec2<i32>(cell) + vec2<i32>(CELL / 2);
    let columns = select(0, i32(frame.size.x) - i32(cell.x), cell.y < frame.size.y);
    let at = tile.slot * PLANES * 64u + lane;
    var cells = load(at + 128u);
    for (var k = tile.entries.x; k < tile.entries.y; k++) {
        let entry = entries[k];
        let cone = cones[entry.cone >> ENTRY_SHIFT];
        var row = member_row(cone, centre - cone.sensor);
        clip(&row, columns);
        if (cone.flags & NO_ECHO) != 0u {
            row.arc = vec4<bool>(false);
        }
        var part = vec4<f32>(0.0);
        if any(row.interior | row.arc) {
            part = weigh_cells(cone, row, &cells);
        }
        if (entry.cone & ARC) != 0u {
            parts[entry.slot * 64u + lane] = (part.x + part.y) + (part.z + part.w);
        }
    }
}
