// Bayesian occupancy grid (Elfes 1989; likelihoods of Murphy 2000, expressions 11.1 to 11.6); twin of src/method/bayes.rs.

const PLANES: u32 = 5u;

// Whether two constants replace Murphy's profile. A cell then has no state besides the two counts.
override CONSTANT: bool = false;

fn member_row(cone: Cone, v: vec2<i32>) -> Row {
    return cone_row(cone, v);
}

fn fuse_cells(cone: Cone, row: Row, share: vec4<u32>, cells: ptr<function, CellStates>) {
    if CONSTANT {
        return;
    }
    let at = polar(cone, row);
    let p = likelihood(murphy(cone.profile.x, at.distance, at.turn), row.arc);
    let other = 1.0 - p;
    let member = row.interior | row.arc;
    let occupied = (*cells).occupied * select(other, p, row.arc);
    let empty = (*cells).empty * select(p, other, row.arc);
    (*cells).occupied = select((*cells).occupied, occupied, member);
    (*cells).empty = select((*cells).empty, empty, member);
}
