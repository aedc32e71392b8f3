// Certainty grid (Moravec & Elfes 1985); twin of src/method/certainty.rs, which says why a cell keeps complements.

const PLANES: u32 = 4u;

// The bound below which a complement is counted in units of 2⁻⁵³.
const NEARLY: f32 = 4.656613e-10;
// Number of units of 2⁻⁵³ in 1.
const UNITS: f32 = 9.007199e15;

// The complements of four cells' certainties.
struct CellStates {
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

// The complement of E + (e − E·e), from those of E and of e: their product, and where E is nearly 1 what f64 makes of it.
fn enhanced(rest: vec4<f32>, not_e: vec4<f32>) -> vec4<f32> {
    let product = rest * not_e;
    let nearly = min(rest, product) < vec4<f32>(NEARLY);
    // Most cells are not nearly certain.
    if any(nearly) {
        return select(product, in_units(rest, not_e), nearly);
    }
    return product;
}

// enhanced near certainty: the bracket is rounded to the last place of e, the sum to that of E, both half to even.
fn in_units(rest: vec4<f32>, not_e: vec4<f32>) -> vec4<f32> {
    let e = 1.0 - not_e;
    let exponent = min(bitcast<vec4<i32>>(e) >> vec4<u32>(23u), vec4<i32>(126));
    let place = bitcast<vec4<f32>>((exponent + 1) << vec4<u32>(23u));
    let per_place = bitcast<vec4<f32>>((253 - exponent) << vec4<u32>(23u));
    let units = rest * UNITS;
    let gone = round(e * units * per_place) * place;
    let left = select(rest * not_e * UNITS, units - gone, rest < vec4<f32>(NEARLY));
    return round(left) * (1.0 / UNITS);
}

// Occ_k = (1 − ((d − R)/ε)²)(1 − t²).
fn occ(profile: vec4<f32>, d: vec4<f32>, turn: vec4<f32>) -> vec4<f32> {
    let e = (d - profile.z) * profile.w;
    return max(1.0 - e * e, vec4<f32>(0.0)) * max(1.0 - turn * turn, vec4<f32>(0.0));
}

// 1 − Occ_k/Σ Occ_k: 0 for a cell that has all of it, 1 for every cell if there is none.
fn not_normalised(evidence: vec4<f32>, sum: f32) -> vec4<f32> {
    let part = select(vec4<f32>(1.0), evidence / sum, evidence < vec4<f32>(sum));
    return select(vec4<f32>(1.0), 1.0 - part, sum > 0.0);
}

fn member_row(cone: Cone, v: vec2<i32>) -> Row {
    return cone_row(cone, v);
}

fn load(at: u32) -> CellStates {
    return CellStates(from_one(state[at]), from_one(state[at + 64u]));
}

fn store(cells: CellStates, at: u32) {
    state[at] = to_one(cells.open);
    state[at + 64u] = to_one(cells.clear);
}

fn weigh_cells(cone: Cone, row: Row, cells: ptr<function, CellStates>) -> vec4<f32> {
    let at = polar(cone, row);
    if (frame.mode & FREE) != 0u {
        let open = enhanced((*cells).open, not_emp(cone.profile, at.distance, at.turn));
        (*cells).open = select((*cells).open, open, row.interior);
    }
    let occupied = occ(cone.profile, at.distance, at.turn) * (*cells).open;
    return select(vec4<f32>(0.0), occupied, row.arc);
}

fn fuse_cells(cone: Cone, row: Row, share: vec4<u32>, cells: ptr<function, CellStates>) {
    let evidence = weigh_cells(cone, row, cells);
    if (frame.mode & OCCUPY) == 0u || !any(row.arc) {
        return;
    }
    let clear = enhanced((*cells).clear, not_normalised(evidence, bitcast<f32>(share.x)));
    (*cells).clear = select((*cells).clear, clear, row.arc);
}

fn renormalize(cells: ptr<function, CellStates>) {}
