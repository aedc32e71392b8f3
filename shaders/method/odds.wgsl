// Log odds as a pair of products, and Murphy's likelihoods (2000, expressions 11.1 and 11.2); twin of src/method/odds.rs.

// The largest P(s|·). A likelihood of 1 would be a certainty that no later reading could change.
const MOST: f32 = 0.98;

// The bits of a number's fraction.
const MANTISSA: vec4<i32> = vec4<i32>(0x7fffff);

// The products of four cells' likelihoods.
struct CellStates {
    // Π P(s|occupied).
    occupied: vec4<f32>,
    // Π P(s|empty).
    empty: vec4<f32>,
    // The power of two by which occupied over empty is to be multiplied.
    scale: vec4<i32>,
}

// P(s|occupied) on the arc (region I), P(s|empty) in the interior (region II), by Murphy's profile.
fn likelihood(near: vec4<f32>, arc: vec4<bool>) -> vec4<f32> {
    let given = frame.constants[0];
    let part = select(vec4<f32>(given.y), vec4<f32>(given.x), arc);
    let least = select(vec4<f32>(given.w), vec4<f32>(given.z), arc);
    return min(max(near * part, least), vec4<f32>(MOST));
}

fn load(at: u32) -> CellStates {
    return CellStates(from_one(state[at]), from_one(state[at + 64u]), bitcast<vec4<i32>>(state[at + 128u]));
}

fn store(cells: CellStates, at: u32) {
    state[at] = to_one(cells.occupied);
    state[at + 64u] = to_one(cells.empty);
    state[at + 128u] = bitcast<vec4<u32>>(cells.scale);
}

fn renormalize(cells: ptr<function, CellStates>) {
    let occupied = bitcast<vec4<i32>>((*cells).occupied);
    let empty = bitcast<vec4<i32>>((*cells).empty);
    let places = vec4<u32>(23u);
    let one = vec4<i32>(i32(ONE_BITS));
    (*cells).scale = (*cells).scale + (occupied >> places) - (empty >> places);
    (*cells).occupied = bitcast<vec4<f32>>((occupied & MANTISSA) | one);
    (*cells).empty = bitcast<vec4<f32>>((empty & MANTISSA) | one);
}
