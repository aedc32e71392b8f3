// Bayesian occupancy grid (Elfes 1989; likelihoods of Murphy 2000, expressions 11.1 to 11.6); twin of src/method/bayes.rs.

const PLANES: u32 = 3u;

// P(s|·) is kept within these: certainty would leave no way back.
const LEAST: f32 = 0.02;
const MOST: f32 = 0.98;

// Two constants instead of Murphy's profile: the counts are all its state.
override CONSTANT: bool = false;

// The log odds of occupied of four cells.
struct Cells {
    odds: vec4<f32>,
}

// What a reading adds to the log odds of occupied, by Murphy's profile.
fn evidence(near: vec4<f32>, arc: vec4<bool>) -> vec4<f32> {
    let max_occ = frame.constants[0].x;
    let floor_one = vec4<f32>(frame.constants[0].y);
    let floor_two = vec4<f32>(frame.constants[0].z);
    // Region I: P(s|occupied); region II: P(s|empty).
    let region = select(max(near, floor_two), max(near * max_occ, floor_one), arc);
    let p = clamp(region, vec4<f32>(LEAST), vec4<f32>(MOST));
    let l = log_4(p / (1.0 - p));
    return select(-l, l, arc);
}

fn member_row(cone: Cone, v: vec2<i32>) -> Row {
    return cone_row(cone, v);
}

fn load(at: u32) -> Cells {
    return Cells(bitcast<vec4<f32>>(state[at]));
}

fn store(cells: Cells, at: u32) {
    state[at] = bitcast<vec4<u32>>(cells.odds);
}

fn fuse_cells(cone: Cone, row: Row, share: vec4<u32>, cells: ptr<function, Cells>) {
    if CONSTANT {
        return;
    }
    let at = polar(cone, row);
    let l = evidence(murphy(cone.profile.x, at.distance, at.turn), row.arc);
    (*cells).odds = (*cells).odds + select(vec4<f32>(0.0), l, row.interior | row.arc);
}
