// The snapped cone in 64 bits, for readings that reach farther than 1024 cells; twin of src/geometry/cone/wide.rs (Wide, on_axis_wide).
// The integers are those of int64.wgsl.

// narrow_row in 64 bits.
fn wide_row(cone: Cone, first: vec2<i32>) -> Row {
    let left_limit = wide_from(-i32((cone.flags & HALF_OPEN) != 0u));
    let narrow = (cone.flags & NARROW_BEAM) != 0u;
    let inner = wide_mul(cone.reach.x, cone.reach.x);
    let outer = wide_mul(cone.reach.y, cone.reach.y);
    let half = wide_from(CELL / 2 * DIRECTION);
    let far = wide_mul(cone.reach.y, DIRECTION);
    var row: Row;
    for (var k = 0; k < 4; k++) {
        let v = first + vec2<i32>(CELL * k, 0);
        let d2 = wide_dot(v, v);
        let across = wide_abs(wide_cross(cone.axis, v));
        let along = wide_dot(cone.axis, v);
        let ahead = !wide_negative(along);
        let wedge = !wide_less(left_limit, wide_cross(cone.left, v)) && !wide_negative(wide_cross(cone.right, v)) && ahead;
        let band = narrow && !wide_less(half, across) && ahead && !wide_less(far, along);
        let inside = wedge || band;
        row.interior[k] = inside && wide_less(d2, inner);
        row.arc[k] = inside && !wide_less(d2, inner) && !wide_less(outer, d2);
        row.d2[k] = wide_float(d2);
        row.across[k] = wide_float(across);
        row.along[k] = select(0.0, wide_float(along), ahead);
    }
    return row;
}

// narrow_axis_row in 64 bits.
fn wide_axis_row(cone: Cone, first: vec2<i32>) -> Row {
    let steep = abs(cone.axis.y) > abs(cone.axis.x);
    let c = select(cone.axis.x, cone.axis.y, steep);
    let s = select(cone.axis.y, cone.axis.x, steep);
    let sgn = sign(c);
    let edge = wide_from(CELL / 2 * abs(c));
    let half = wide_from(CELL / 2 * DIRECTION);
    var row: Row;
    for (var k = 0; k < 4; k++) {
        let v = first + vec2<i32>(CELL * k, 0);
        let a = select(v.x, v.y, steep);
        let b = select(v.y, v.x, steep);
        let side = wide_sub(wide_mul(b, c * sgn), wide_mul(a, s * sgn));
        let on = a * sgn >= 0 && !wide_less(side, wide_neg(edge)) && wide_less(side, edge);
        let past = wide_sub(wide_mul(DIRECTION, a * sgn), wide_mul(cone.reach.x, abs(c)));
        let before = on && wide_less(past, wide_neg(half));
        let hit = on && !wide_less(past, wide_neg(half)) && wide_less(past, half);
        let silent = (cone.flags & NO_ECHO) != 0u;
        row.interior[k] = before || (hit && silent);
        row.arc[k] = hit && !silent;
    }
    return row;
}

fn cone_row(cone: Cone, v: vec2<i32>) -> Row {
    if (cone.flags & WIDE) != 0u {
        return wide_row(cone, v);
    }
    return narrow_row(cone, v);
}

fn axis_row(cone: Cone, v: vec2<i32>) -> Row {
    if (cone.flags & WIDE) != 0u {
        return wide_axis_row(cone, v);
    }
    return narrow_axis_row(cone, v);
}
