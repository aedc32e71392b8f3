// Feature-based occupancy grid (IJCAI 2007): the weighted evidence of an update; twin of src/method/features.rs.

const PLANES: u32 = 6u;

// Bit of a cell's code: the first part occupies the cell. The bits of the second part and of the routine part follow, two
// positions higher each.
const OCCUPIED: u32 = 1u;
// Bit of a cell's code: the first part frees the cell. The other sources' bits follow as for OCCUPIED.
const FREED: u32 = 2u;

// The mark of an update's code for a cell, a number that tells it from other codes and updates.
fn mark(number: u32, code: vec4<u32>) -> vec4<u32> {
    let mixed = (code ^ vec4<u32>(number * 0x9e3779b1u)) * 0x85ebca6bu;
    return (mixed ^ (mixed >> vec4<u32>(15u))) * 0xc2b2ae35u;
}

// The term that a source adds to ½: weight where it occupies, −weight where it frees.
fn lean(weight: vec4<f32>, code: vec4<u32>, source: u32) -> vec4<f32> {
    let none = vec4<f32>(0.0);
    let occupied = (code & vec4<u32>(OCCUPIED << (2u * source))) != vec4<u32>(0u);
    let freed = (code & vec4<u32>(FREED << (2u * source))) != vec4<u32>(0u);
    return select(select(none, none - weight, freed), weight, occupied);
}

fn member_row(cone: Cone, v: vec2<i32>) -> Row {
    return cone_row(cone, v);
}

// Updates four cells.
fn fuse_cells(cone: Cone, weights: vec4<f32>, row: Row, code: vec4<u32>, cells: ptr<function, CellStates>) {
    // The sum starts from ½, because software adapters add a constant first, wherever it is written.
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
