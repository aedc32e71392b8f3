// Histogrammic in-motion mapping (Borenstein & Koren 1991); twin of src/method/himm.rs.

const PLANES: u32 = 3u;

// A count of one, in units of 1/65536.
const ONE: u32 = 65536u;
const HIT: u32 = 196608u;
const MOST: u32 = 983040u;

struct CellStates {
    count: vec4<u32>,
}

fn member_row(cone: Cone, v: vec2<i32>) -> Row {
    return axis_row(cone, v);
}

fn load(at: u32) -> CellStates {
    return CellStates(state[at]);
}

fn store(cells: CellStates, at: u32) {
    state[at] = cells.count;
}

fn fuse_cells(cone: Cone, row: Row, share: vec4<u32>, cells: ptr<function, CellStates>) {
    let less = max((*cells).count, vec4<u32>(ONE)) - ONE;
    let more = min((*cells).count + HIT, vec4<u32>(MOST));
    (*cells).count = select((*cells).count, less, row.interior);
    (*cells).count = select((*cells).count, more, row.arc);
}

fn renormalize(cells: ptr<function, CellStates>) {}
