// Feature-based occupancy grid (IJCAI 2007): what an update says of a cell, weighted; twin of src/method/features.rs.

const PLANES: u32 = 6u;

// Bit of a cell's code: the first part occupies it; the other part's, the routine part's, two places on each.
const OCCUPIED: u32 = 1u;
// The same: the first part frees it.
const FREED: u32 = 2u;

// A number that tells an update's code of a cell from others.
fn mark(number: u32, code: vec4<u32>) -> vec4<u32> {
    let mixed = (code ^ vec4<u32>(number * 0x9e3779b1u)) * 0x85ebca6bu;
    return (mixed ^ (mixed >> vec4<u32>(15u))) * 0xc2b2ae35u;
}

// What a source adds to ½: this where it occupies, less where it frees.
fn lean(weight: vec4<f32>, code: vec4<u32>, source: u32) -> vec4<f32> {
    let none = vec4<f32>(0.0);
    let occupied = (code & vec4<u32>(OCCUPIED << (2u * source))) != vec4<u32>(0u);
    let freed = (code & vec4<u32>(FREED << (2u * source))) != vec4<u32>(0u);
    return select(select(none, none - weight, freed), weight, occupied);
}

fn member_row(cone: Cone, v: vec2<i32>) -> Row {
    return cone_row(cone, v);
}

// The update of four cells.
fn fuse_cells(cone: Cone, weights: vec4<f32>, row: Row, code: vec4<u32>, cells: ptr<function, CellStates>) {
    // From ½ on: software adapters add a constant first, wherever it stands.
    var sum = vec4<f32>(0.5);
    if any(row.interior | row.arc) {
        let at = polar(cone, row);
        let p = likelihood(murphy(cone.profile.x, at.distance, at.turn), row.arc);
        sum += lean((p - 0.5) * weights.z, code, 2u);
    }
    sum = (sum + lean(vec4<f32>(weights.x), code, 0u)) + lean(vec4<f32>(weights.y), code, 1u);
    let p = min(max(sum, vec4<f32>(1.0 - MOST)), vec4<f32>(MOST));
    let one = vec4<f32>(1.0);
    let member = code != vec4<u32>(0u);
    (*cells).occupied = (*cells).occupied * select(one, p, member);
    (*cells).empty = (*cells).empty * select(one, 1.0 - p, member);
}
