// Stands for wide.wgsl where no reading reaches far; twin of src/geometry/cone.rs (cone_row, axis_row).
//
// It serves batches without a reading that reaches farther than 1024 cells. Software adapters run both sides of a branch, and
// on other adapters the 64-bit code costs registers.

fn cone_row(cone: Cone, v: vec2<i32>) -> Row {
    return narrow_row(cone, v);
}

fn axis_row(cone: Cone, v: vec2<i32>) -> Row {
    return narrow_axis_row(cone, v);
}
