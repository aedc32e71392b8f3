// The laser truth: hits and passes of the nearest beam of each scan; twin of src/method/truth.rs.

const PLANES: u32 = 2u;

// A cell has no state besides the two counts that every method keeps.
struct CellStates {
    none: u32,
}

fn member_row(cone: Cone, v: vec2<i32>) -> Row {
    return cone_row(cone, v);
}

fn load(at: u32) -> CellStates {
    return CellStates(0u);
}

fn store(cells: CellStates, at: u32) {}

fn fuse_cells(cone: Cone, row: Row, share: vec4<u32>, cells: ptr<function, CellStates>) {}

fn renormalize(cells: ptr<function, CellStates>) {}
