// Dempster-Shafer evidential grid (Pagac, Nebot & Durrant-Whyte 1998); twin of src/method/dempster_shafer.rs.

const PLANES: u32 = 6u;

// One, in the units of a logarithm that a kernel computes itself.
const LOG_ONE: f32 = 16777216.0;

// Whether Murphy's masses replace 1/n and ρ.
override MURPHY: bool = false;

// The sums −Σ ln(1 − e) and −Σ ln(1 − f) of four cells, as low and high words.
struct CellStates {
    empty: array<vec4<u32>, 2>,
    full: array<vec4<u32>, 2>,
}

// −ln(1 − m) in units of 2⁻²⁴.
fn weight(m: vec4<f32>) -> vec4<u32> {
    return vec4<u32>(-log_4(1.0 - m) * LOG_ONE + 0.5);
}

// Adds an addend to a 64-bit sum in the cells where `on` is set.
fn add(sum: ptr<function, array<vec4<u32>, 2>>, addend_low: vec4<u32>, addend_high: vec4<u32>, on: vec4<bool>) {
    let zero = vec4<u32>(0u);
    let low = (*sum)[0] + select(zero, addend_low, on);
    let high = select(zero, addend_high, on) + select(zero, vec4<u32>(1u), low < (*sum)[0]);
    (*sum)[0] = low;
    (*sum)[1] = (*sum)[1] + high;
}

fn member_row(cone: Cone, v: vec2<i32>) -> Row {
    return cone_row(cone, v);
}

fn load(at: u32) -> CellStates {
    return CellStates(
        array<vec4<u32>, 2>(state[at], state[at + 64u]),
        array<vec4<u32>, 2>(state[at + 128u], state[at + 192u]),
    );
}

fn store(cells: CellStates, at: u32) {
    state[at] = cells.empty[0];
    state[at + 64u] = cells.empty[1];
    state[at + 128u] = cells.full[0];
    state[at + 192u] = cells.full[1];
}

fn fuse_cells(cone: Cone, row: Row, share: vec4<u32>, cells: ptr<function, CellStates>) {
    var empty = (*cells).empty;
    var full = (*cells).full;
    if !MURPHY {
        add(&empty, vec4<u32>(share.x), vec4<u32>(share.y), row.interior);
        add(&full, vec4<u32>(share.z), vec4<u32>(share.w), row.arc);
    } else {
        let max_occ = frame.constants[0].x;
        let cap = vec4<f32>(frame.constants[0].y);
        let at = polar(cone, row);
        let near = murphy(cone.profile.x, at.distance, at.turn);
        let m = near * select(vec4<f32>(0.5), vec4<f32>(0.5 * max_occ), row.arc);
        let w = weight(clamp(m, vec4<f32>(0.0), cap));
        add(&empty, w << vec4<u32>(16u), w >> vec4<u32>(16u), row.interior);
        add(&full, w << vec4<u32>(16u), w >> vec4<u32>(16u), row.arc);
    }
    (*cells).empty = empty;
    (*cells).full = full;
}

fn renormalize(cells: ptr<function, CellStates>) {}
