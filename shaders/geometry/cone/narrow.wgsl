// Stands for wide.wgsl where no reading reaches far; twin of src/geometry/cone.rs (cone_row, axis_row).
//
// For batches without a reading that reaches farther than 1024 cells: software adapters run both sides of a branch, and on
// others the 64-bit code costs registers.

fn cone_row(cone: Cone, v: vec2<i32>) -> Row {
    return narrow_row(cone, v);
}

fn axis_row(cone: Cone, v: vec2<i32>) -> Row {
    return narrow_axis_row(cone, v);
}
