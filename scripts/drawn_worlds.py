"""Drawn worlds for scripts/features: rooms and bends with objects, the same by seed, and where their true concave corners are."""
import json
import math
import os
import random
import re
import tomllib


def ahead(start, angle, along, across=0):
    """The point so far along a direction, and so far to the left of it."""
    c, s = math.cos(angle), math.sin(angle)
    return start[0] + c * along - s * across, start[1] + s * along + c * across


def arm(start, end):
    """Bearing and distance."""
    return math.atan2(end[1] - start[1], end[0] - start[0]), math.dist(start, end)


def edges(points):
    return list(zip(points, points[1:]))


def to_segment(p, a, b):
    """Distance of a point from a segment."""
    (bearing, length), (seen, far) = arm(a, b), arm(a, p)
    return math.dist(p, ahead(a, bearing, min(max(far * math.cos(seen - bearing), 0), length)))


def clearance(world, p):
    """How near the closest surface of a drawn world is to a point."""
    flat = [to_segment(p, *edge) for o in world["outline"] for edge in edges(o["points"])]
    return min([*flat, *(math.dist(p, c["centre"]) - c["radius"] for c in world.get("circle", []))])


def room(rng):
    """A rectangle, and two to four scans in it."""
    w, h = rng.uniform(3.5, 7), rng.uniform(3.5, 7)
    scans, wanted = [], rng.randint(2, 4)
    while len(scans) < wanted:
        p = rng.uniform(0.5, w - 0.5), rng.uniform(0.5, h - 0.5)
        if all(math.dist(p, q) >= 0.8 for q in scans):
            scans.append(p)
    return {"outline": [{"points": [(0, 0), (w, 0), (w, h), (0, h), (0, 0)], "class": "wall"}], "path": {"poses": scans}}


def stood(rng, half, start, angle, along):
    """A box against a wall of a leg, or a circle before it: the table's name and its keys."""
    side = rng.choice([-1, 1])
    if rng.random() < 0.5:
        # 1 mm into the wall, so that rounding leaves no gap
        wide, deep, wall = rng.uniform(0.3, 0.6), rng.uniform(0.3, 0.6), half + 0.001
        corners = [(-1, wall), (1, wall), (1, wall - deep), (-1, wall - deep), (-1, wall)]
        points = [ahead(start, angle, along + i * wide / 2, side * across) for i, across in corners]
        return "outline", {"points": points, "free": "outside", "class": "box"}
    radius, gap = rng.uniform(0.15, 0.25), rng.uniform(0.1, 0.35)
    return "circle", {"centre": ahead(start, angle, along, side * (half - gap - radius)), "radius": radius, "class": "can"}


def middle(rng, start, angle, first, last):
    """Places of a path along a leg, each off the middle by up to 15 cm."""
    count = max(2, round((last - first) / 1.5) + 1)
    places = [first + (last - first) * i / (count - 1) for i in range(count)]
    return [ahead(start, angle, p + rng.uniform(-0.15, 0.15), rng.uniform(-0.15, 0.15)) for p in places]


def bend(rng):
    """A corridor of two legs, measured along its middle, that turns left, and an object or two."""
    half, a, b = rng.uniform(0.8, 1.2), rng.uniform(4, 7), rng.uniform(4, 7)
    turn, corner = math.radians(rng.uniform(30, 85)), (a, 0)
    mitre = half * math.tan(turn / 2)
    right = [(0, -half), (a + mitre, -half), ahead(corner, turn, b, -half)]
    left = [ahead(corner, turn, b, half), (a - mitre, half), (0, half)]
    world = {"outline": [{"points": [*right, *left, right[0]], "class": "wall"}]}
    legs = [((0, 0), 0, rng.uniform(0.8, a - mitre - 0.6)), (corner, turn, rng.uniform(mitre + 0.6, b - 0.8))]
    for leg in rng.sample(legs, rng.randint(1, 2)):
        table, keys = stood(rng, half, *leg)
        world.setdefault(table, []).append(keys)
    points = middle(rng, (0, 0), 0, 0.75, a) + middle(rng, corner, turn, 1.2, b - 0.75)
    world["path"] = {"points": points, "step": rng.uniform(0.3, 0.5), "speed": 0.5}
    along = [ahead(p, arm(p, q)[0], arm(p, q)[1] * i / 20) for p, q in edges(points) for i in range(21)]
    return world if min(clearance(world, p) for p in along) >= 0.3 else bend(rng)


def moved(rng, world):
    """The world or its mirror image, turned by any angle and shifted off the cell grid."""
    flip, turn, shift = rng.choice([-1, 1]), rng.uniform(-math.pi, math.pi), (rng.uniform(0, 1), rng.uniform(0, 1))
    for table in [*world["outline"], *world.get("circle", []), world["path"]]:
        for key in {"points", "poses"} & table.keys():
            table[key] = [ahead(shift, turn, x, flip * y) for x, y in table[key]]
        if "centre" in table:
            table["centre"] = ahead(shift, turn, table["centre"][0], flip * table["centre"][1])
    return world


def rounded(value):
    """To 0.1 mm, in lists too."""
    if isinstance(value, (list, tuple)):
        return [rounded(v) for v in value]
    return round(value, 4) if isinstance(value, float) else value


def as_toml(name, world):
    shapes = [(f"[[{table}]]", shape) for table in ("outline", "circle") for shape in world.get(table, [])]
    text = f'name = "{name}"\n'
    for head, keys in [*shapes, ("[path]", world["path"])]:
        text += f"\n{head}\n" + "".join(f"{key} = {json.dumps(rounded(value))}\n" for key, value in keys.items())
    return text


def stepped(world, name, step):
    """A world's text with another distance from scan to scan."""
    with open(world) as file:
        return re.sub(r"(?m)^step = .*", f"step = {step}", re.sub(r"(?m)^name = .*", f'name = "{name}"', file.read()))


def write_worlds(folder, seed, count, bend_world):
    """Writes the drawn worlds and the weak spots: a long room from two scans, `bend_world` with few. Returns the paths of both."""
    rng, drawn = random.Random(seed), {}
    for i in range(1, count + 1):
        kind = bend if i % 2 else room
        name = f"gen-{i:02}-{kind.__name__}"
        drawn[name] = as_toml(name, moved(rng, kind(rng)))
    outline = [[0.02, 0.03], [7.02, 0.03], [7.02, 3.03], [0.02, 3.03], [0.02, 0.03]]
    long = {"outline": [{"points": outline, "class": "wall"}], "path": {"poses": [[2.1, 1.2], [4.9, 1.9]]}}
    weak = {"room-7x3": as_toml("room-7x3", long), "bend-sparse": stepped(bend_world, "bend-sparse", 0.7)}
    os.makedirs(folder, exist_ok=True)
    for name, text in (drawn | weak).items():
        with open(f"{folder}/{name}.toml", "w") as file:
            file.write(text)
    return [[f"{folder}/{name}.toml" for name in some] for some in (drawn, weak)]


def box_outline(box):
    """A box that isn't turned, as the named worlds have them."""
    (x, y), (w, h) = box["centre"], box["size"]
    return {"points": [(x + i * w / 2, y + j * h / 2) for i, j in [(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]], "free": "outside"}


def corner_places(points):
    return zip([points[-2], *points], points[:-1], points[1:])


def bent(outline):
    """An outline's own concave corners, as seen from its free side, of 25° to 155°."""
    points = outline["points"]
    counter_clockwise = sum(a[0] * b[1] - a[1] * b[0] for a, b in edges(points)) > 0
    left_free = counter_clockwise == (outline.get("free", "inside") == "inside")
    for before, at, after in corner_places(points):
        back, on = arm(at, before), arm(at, after)
        angle = math.degrees(back[0] - on[0] if left_free else on[0] - back[0]) % 360
        if 25 <= angle <= 155:
            yield at, back, on


def stood_against(points, edge):
    """The corners that an object makes with a wall that it touches."""
    for before, at, after in corner_places(points):
        if to_segment(at, *edge) < 0.005:
            foot, top = sorted([before, after], key=lambda p: to_segment(p, *edge))
            onward = max(edge, key=lambda end: math.dist(end, foot) - math.dist(end, at))
            yield at, arm(at, top), arm(at, onward)


def true_corners(path):
    """The concave corners of a world's outlines and boxes, each with its two walls: bearing and length."""
    with open(path, "rb") as file:
        world = tomllib.load(file)
    outlines = world["outline"] + [box_outline(b) for b in world.get("box", [])]
    objects = [o for o in outlines if o.get("free") == "outside"]
    walls = [(one, edge) for one in objects for other in outlines if other is not one for edge in edges(other["points"])]
    return [c for o in outlines for c in bent(o)] + [c for one, edge in walls for c in stood_against(one["points"], edge)]
