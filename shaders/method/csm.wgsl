// Counting sensor models: a Dirichlet over classes in each cell, from the beams of its nearest poses; twin of src/method/csm.rs.
//
// The host declares CONTINUOUS, SEMANTIC, FREE_RULE (0 projection, 1 sample, 2 clamp), NEIGHBOURS (0: all), HELD (at least 1),
// PLANES and ALPHAS.

const FINE: u32 = 1024u;

// A cell's words while beams update it.
struct Cell {
    interior: u32,
    arc: u32,
    marks: u32,
    alpha: array<u32, ALPHAS>,
}

// The kernel at a distance, µm: in s = 1 - d/l it is odd and starts with s^5.
fn kernel(d: f32) -> f32 {
    let s = max(1.0 - d * frame.constants[0].x, 0.0);
    let y = s * s;
    var sum = 0.0007129185;
    sum = sum * y + -0.009528071;
    sum = sum * y + 0.07669427;
    sum = sum * y + -0.4567195;
    sum = sum * y + 2.026378;
    sum = sum * y + -6.4063287;
    sum = sum * y + 13.387694;
    sum = sum * y + -16.277489;
    sum = sum * y + 8.658586;
    return frame.constants[0].y * ((y * y * s) * sum);
}

fn add_float(cell: ptr<function, Cell>, class_: u32, value: f32) {
    (*cell).alpha[class_] = bitcast<u32>(bitcast<f32>((*cell).alpha[class_]) + value);
}

// The mark of a scan's beam, a number that tells it, including its label, from others.
fn mark(scan: u32, id: u32) -> u32 {
    let mixed = ((scan * 0x9e3779b1u) ^ (id & ~(IDLE | YIELD))) * 0x85ebca6bu;
    return (mixed ^ (mixed >> 15u)) * 0xc2b2ae35u;
}

// Updates a cell, at v from the scan's pose, with the scan's nearest beam; square is v·v.
fn update(scan: u32, beam: Beam, v: vec2<i32>, square: vec2<u32>, cell: ptr<function, Cell>) {
    if (beam.id & IDLE) != 0u {
        return;
    }
    if CONTINUOUS {
        continuous(scan, beam, v, cell);
    } else {
        discrete(scan, beam, v, square, cell);
    }
}

fn discrete(scan: u32, beam: Beam, v: vec2<i32>, square: vec2<u32>, cell: ptr<function, Cell>) {
    let right = wide_cross(beam.ray[0], v);
    let left = wide_neg(wide_cross(beam.ray[1], v));
    if wide_negative(right) || wide_negative(left) {
        return;
    }
    let half = frame.limits.y;
    let inner = max(beam.range - half, 0);
    let outer = beam.range + half;
    let label = beam.id & 255u;
    let before = !wide_less(wide_mul(inner, inner), square);
    if !before && wide_less(square, wide_mul(outer, outer)) {
        if label > 0u {
            (*cell).arc += 1u;
            (*cell).marks += mark(scan, beam.id);
            if SEMANTIC {
                (*cell).alpha[label - 1u] += 1u;
            }
        }
    } else if before {
        (*cell).interior += 1u;
        (*cell).marks += mark(scan, beam.id);
    }
}

// Adds the evidence of free space from a point of the beam, `across` 1/1024 µm to the side and `offset` µm along. Returns whether it
// touches the cell.
fn free(across: u32, offset: i32, cell: ptr<function, Cell>) -> bool {
    let p = f32(across) * (1.0 / f32(FINE));
    let o = f32(offset);
    let near = touches(vec2<i32>(i32(across / FINE), offset));
    add_float(cell, 0u, kernel(sqrt(p * p + o * o)));
    (*cell).interior += select(0u, 1u, near);
    return near;
}

// Whether the kernel at this distance, µm, is more than 1e-6.
fn touches(away: vec2<i32>) -> bool {
    return wide_less(wide_dot(away, away), wide_mul(frame.limits.y, frame.limits.y));
}

fn continuous(scan: u32, beam: Beam, v: vec2<i32>, cell: ptr<function, Cell>) {
    let unit = beam.ray[0];
    let step = frame.limits.z;
    let l = frame.limits.w;
    let along = wide_dot(unit, v);
    if FREE_RULE == 0u && wide_negative(along) {
        return;
    }
    var marked = false;
    let label = beam.id & 255u;
    let e = v - beam.ray[1];
    if label > 0u && max(abs(e.x), abs(e.y)) < l {
        let f = vec2<f32>(e);
        let near = touches(e);
        add_float(cell, label, kernel(sqrt(f.x * f.x + f.y * f.y)));
        (*cell).arc += select(0u, 1u, near);
        marked = marked || near;
    }
    // Across the beam in 1/1024 µm, along it in µm.
    let side = wide_abs(wide_cross(unit, v));
    let across = (side.x >> 15u) | (side.y << 17u);
    if (side.y >> 15u) == 0u && across < u32(l) * FINE {
        let whole = bitcast<i32>((along.x >> 25u) | (along.y << 7u));
        if FREE_RULE == 0u {
            if !wide_less(wide_mul(beam.range, UNIT), along) {
                marked = free(across, 0, cell) || marked;
            }
        } else if FREE_RULE == 2u {
            let offset = whole - clamp(whole, 0, max(beam.range - l, 0));
            if abs(offset) < l {
                marked = free(across, offset, cell) || marked;
            }
        } else {
            let last = min(whole + l, beam.range);
            var k = max(whole - l, 0) / step;
            while k * step <= last {
                if abs(whole - k * step) < l {
                    marked = free(across, whole - k * step, cell) || marked;
                }
                k += 1;
            }
        }
    }
    if marked {
        (*cell).marks += mark(scan, beam.id);
    }
}
