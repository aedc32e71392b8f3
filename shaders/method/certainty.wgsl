// Certainty grid (Moravec & Elfes 1985); twin of src/method/certainty.rs, which says why a cell keeps complements.

const PLANES: u32 = 4u;

// 1 − Emp below this is 0: the spacing of f64 just below 1, halved.
const CERTAIN: f32 = 5.551115e-17;

// The complements of four cells' certainties.
struct Cells {
    // 1 − Emp.
    open: vec4<f32>,
    // 1 − Occ.
    clear: vec4<f32>,
}

// 1 − Emp_k, without cancellation: Emp_k = (1 − p²)(1 − t²), p = (d − r_min)/(R − ε − r_min), t = θ/β.
fn not_emp(profile: vec4<f32>, d: vec4<f32>, turn: vec4<f32>) -> vec4<f32> {
    let p = max(d - profile.x, vec4<f32>(0.0)) * profile.y;
    let p2 = min(p * p, vec4<f32>(1.0));
    let t2 = min(turn * turn, vec4<f32>(1.0));
    return p2 + t2 * (1.0 - p2);
}

// Occ_k = (1 − ((d − R)/ε)²)(1 − t²).
fn occ(profile: vec4<f32>, d: vec4<f32>, turn: vec4<f32>) -> vec4<f32> {
    let e = (d - profile.z) * profile.w;
    return max(1.0 - e * e, vec4<f32>(0.0)) * max(1.0 - turn * turn, vec4<f32>(0.0));
}

fn member_row(cone: Cone, v: vec2<i32>) -> Row {
    return cone_row(cone, v);
}

fn load(at: u32) -> Cells {
    return Cells(bitcast<vec4<f32>>(state[at]), bitcast<vec4<f32>>(state[at + 64u]));
}

fn store(cells: Cells, at: u32) {
    state[at] = bitcast<vec4<u32>>(cells.open);
    state[at + 64u] = bitcast<vec4<u32>>(cells.clear);
}

fn weigh_cells(cone: Cone, row: Row, cells: ptr<function, Cells>) -> vec4<f32> {
    let at = polar(cone, row);
    let free = vec4<bool>((frame.mode & FREE) != 0u);
    var open = (*cells).open * not_emp(cone.profile, at.distance, at.turn);
    open = select(open, vec4<f32>(0.0), open < vec4<f32>(CERTAIN));
    (*cells).open = select((*cells).open, open, row.interior & free);
    let occupied = occ(cone.profile, at.distance, at.turn) * (*cells).open;
    return select(vec4<f32>(0.0), occupied, row.arc);
}

fn fuse_cells(cone: Cone, row: Row, share: vec4<u32>, cells: ptr<function, Cells>) {
    let evidence = weigh_cells(cone, row, cells);
    if (frame.mode & OCCUPY) == 0u {
        return;
    }
    let normaliser = bitcast<f32>(share.x);
    (*cells).clear = (*cells).clear * max(1.0 - evidence * normaliser, vec4<f32>(0.0));
}
