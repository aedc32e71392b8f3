"""What a sonar ought to hear in a world, from the equations of docs/worlds.md, set against a simulated log.

    echoes.py WORLD.toml LOG.jsonl BOUNCES [--allow SHARE]

The log must come from a rig without noise, flutter, false echoes and cross-talk. Each echo is found by image sources,
for all readings at once; nothing here follows the Rust in src/world/, so that one can check the other. Says how many
readings agree, describes the first ten that don't, and fails if they are more than the share that is allowed.
"""

import argparse
import json
import math
import sys
import tomllib
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np

REFLECTION = {"specular": 0.95, "glass": 0.95, "diffuse": 0.3, "absorbing": 0.2}
SCATTER = 0.3  # what a rough place sends back of a sound that falls on it squarely
JOIN = 1e-3  # walls nearer than this join, metres
STRAIGHT = math.radians(2)  # a joint that turns by less is no corner
SQUARE = math.radians(4)  # a corner this near to 90° returns every sound
HAIR = 1e-6  # a leg of a sound's way may touch the walls at its ends, metres
PLACES = 33  # places that answer along a rough wall's part in the beam; four times as many steps round an arc
TOLERANCE = 0.01001  # ranges are whole centimetres
TAU = 2 * math.pi


def loss(d):
    """A(d) = e^(−0.36 d)/d: what spreading and the air leave."""
    return np.exp(-0.36 * d) / d


KAPPA = math.log(loss(0.15) / loss(5.0)) / 2


def cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def bearing(v):
    return np.arctan2(v[..., 1], v[..., 0])


def length(v):
    return np.hypot(v[..., 0], v[..., 1])


def towards(angle):
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


@dataclass
class Wall:
    """A straight wall, and whether its sides to the left and the right of the way from a to b are free."""

    a: np.ndarray
    b: np.ndarray
    left: bool
    right: bool
    surface: str

    def __post_init__(self):
        self.along, self.length = self.b - self.a, length(self.b - self.a)
        self.run = self.along / self.length
        self.normal = np.array([-self.run[1], self.run[0]])
        self.keeps = REFLECTION[self.surface]

    def height(self, p):
        """How far points lie to its left."""
        return (p - self.a) @ self.normal

    def faces(self, p):
        """Whether points lie on a free side."""
        return ((self.height(p) > 1e-9) & self.left) | ((self.height(p) < -1e-9) & self.right)

    def image(self, p):
        return p - 2 * self.height(p)[..., None] * self.normal

    def joins(self, p):
        x = (p - self.a) @ self.run
        return abs(self.height(p)) <= JOIN and -JOIN <= x <= self.length + JOIN

    def meets(self, p, way):
        """Where rays meet it, as shares of their way; NaN beyond its ends."""
        den = cross(way, self.along)
        t, u = cross(self.a - p, self.along) / den, cross(self.a - p, way) / den
        return [np.where((u >= 0) & (u <= 1), t, np.nan)]


@dataclass
class Arc:
    """A circle, solid on one side, or a part of one, thin, that answers on both."""

    centre: np.ndarray
    radius: float
    start: float
    sweep: float
    inside: bool
    surface: str

    def spans(self, p):
        return (self.sweep >= TAU) | ((bearing(p - self.centre) - self.start) % TAU <= self.sweep)

    def answers(self, at, p):
        """Whether its points `at` answer to sound from p: a whole circle's on its free side only."""
        within = ((p - at) * (at - self.centre)).sum(-1) < 0
        return self.spans(at) & ((within == self.inside) | (self.sweep < TAU))

    def meets(self, p, way):
        """Where rays meet it: the roots of |p + t·way − centre| = radius, NaN where it has no such point."""
        v = p - self.centre
        a, b, c = (way**2).sum(-1), (v * way).sum(-1), (v**2).sum(-1) - self.radius**2
        roots = [(-b + sign * np.sqrt(b * b - a * c)) / a for sign in (-1, 1)]
        return [np.where(self.spans(p + t[..., None] * way), t, np.nan) for t in roots]


@dataclass
class Corner:
    """A concave corner or a convex edge: from the bearing `start` counter-clockwise over `opening` all is free."""

    at: np.ndarray
    start: float
    opening: float
    keeps: list  # the reflections of its two walls

    def rho(self, d):
        """Edge 0.10/√d, square corner 0.9·0.95², other corner 0.05/√d; less where the walls aren't smooth."""
        one, other = (keeps / 0.95 for keeps in self.keeps)
        if self.opening > math.pi:
            return 0.10 / np.sqrt(d) * min(one, other)
        square = abs(self.opening - math.pi / 2) <= SQUARE
        return (0.9 * 0.95**2 if square else 0.05 / np.sqrt(d)) * one * other * np.ones_like(d)

    def faces(self, p):
        return (bearing(p - self.at) - self.start) % TAU <= self.opening


def number(value):
    """A length or an angle: a number, or a text with its unit."""
    for unit, factor in [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("deg", math.pi / 180), ("rad", 1.0)]:
        if isinstance(value, str) and value.endswith(unit):
            return float(value.removesuffix(unit)) * factor
    return float(value)


def numbers(values):
    return np.array([number(v) for v in values])


def ring(box):
    """A box's corners, counter-clockwise, the first again at the end."""
    turn = number(box.get("turn", 0))
    sides = numbers(box["size"])[:, None] / 2 * towards(np.array([turn, turn + math.pi / 2]))
    signs = [(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]
    return [numbers(box["centre"]) + np.array(s) @ sides for s in signs]


def read_world(path):
    """A world's walls and arcs."""
    with open(path, "rb") as file:
        world = tomllib.load(file)
    walls, arcs = [], []
    for kind, free in (("outline", "inside"), ("wall", None), ("box", "outside")):
        for shape in world.get(kind, []):
            points = ring(shape) if kind == "box" else [numbers(p) for p in shape["points"]]
            counter_clockwise = sum(cross(p, q) for p, q in pairwise(points)) > 0
            left = counter_clockwise == (shape.get("free", free) == "inside")
            sides = (True, True) if kind == "wall" else (left, not left)
            walls += [Wall(p, q, *sides, shape.get("surface", "specular")) for p, q in pairwise(points)]
    for shape in world.get("circle", []):
        start, end = number(shape.get("from", 0)), number(shape.get("to", TAU))
        sweep = TAU if abs(end - start) >= TAU - 1e-9 else (end - start) % TAU
        centre, inside = numbers(shape["centre"]), shape.get("free") == "inside"
        arcs.append(Arc(centre, number(shape["radius"]), start, sweep, inside, shape.get("surface", "specular")))
    return walls, arcs


def joints(walls):
    """The places where walls cross, stand against each other or end; places nearer than JOIN are one."""
    places = []
    for one, other in product(walls, walls):
        den = cross(one.along, other.along)
        if abs(den) > 1e-9 * one.length * other.length:
            place = one.a + cross(other.a - one.a, other.along) / den * one.along
            places += [place] if one.joins(place) and other.joins(place) else []
    distinct = []
    for place in places + [end for wall in walls for end in (wall.a, wall.b)]:
        if all(length(place - p) >= JOIN for p in distinct):
            distinct.append(place)
    return distinct


def find_corners(walls):
    """At every joint a corner or an edge for each free sector between neighbouring walls."""
    found = []
    for at in joints(walls):
        arms = []  # bearing, whether left and right of it are free, reflection
        for wall in (w for w in walls if w.joins(at)):
            if length(wall.b - at) > 2 * JOIN:
                arms.append([bearing(wall.run) % TAU, wall.left, wall.right, wall.keeps])
            if length(wall.a - at) > 2 * JOIN:
                arms.append([bearing(-wall.run) % TAU, wall.right, wall.left, wall.keeps])
        distinct = []
        for arm in sorted(arms):
            # walls that lie on one another are one arm, free where all of them are
            same = [m for m in distinct if abs((m[0] - arm[0] + math.pi) % TAU - math.pi) < STRAIGHT]
            if same:
                same[0][1:3] = same[0][1] and arm[1], same[0][2] and arm[2]
            else:
                distinct.append(arm)
        for arm, following in zip(distinct, distinct[1:] + distinct[:1]):
            opening = (following[0] - arm[0]) % TAU if len(distinct) > 1 else TAU
            if arm[1] and following[2] and abs(opening - math.pi) > STRAIGHT:
                found.append(Corner(at, arm[0], opening, [arm[3], following[3]]))
    return found


class Sound:
    """A log's readings, and for each the nearest echo of up to `bounces` events."""

    def __init__(self, walls, arcs, log, bounces):
        with open(log, encoding="utf-8") as file:
            header, *readings = map(json.loads, file)
        sensors = [header["sensors"][r["sensor"]] for r in readings]
        self.half_width, self.r_min, self.r_max = (
            np.array([s[key] for s in sensors]) for key in ("half_width", "r_min", "r_max")
        )
        self.at = np.array([(r["x"], r["y"]) for r in readings])
        self.heading = np.array([r["h"] for r in readings])
        self.range = np.array([math.inf if r["z"] is None else r["z"] for r in readings])
        self.walls, self.arcs = walls, arcs
        self.nearest, self.what = np.full(len(readings), math.inf), ["no echo"] * len(readings)
        # pairs of walls some of each of which lies on a free side of the other
        sees = [[np.any(one.faces(np.array([other.a, other.b]))) for other in walls] for one in walls]
        self.facing = {(i, j) for i, j in product(range(len(walls)), repeat=2) if sees[i][j] and sees[j][i]}
        corners = find_corners(walls)
        self.walls_in_turn(1)
        self.rough_surfaces()
        for mirror in [None, *range(len(walls))] if bounces == 3 else [None]:
            self.corners_and_arcs(corners, mirror)
        for events in range(2, bounces + 1):
            self.walls_in_turn(events)

    def audible(self, d, departs, arrives, rho, ok):
        """Readings that may hear an echo: A(d)·e^(−κ(θt² + θr²)/β²)·ρ ≥ A(r_max)/1.5, and nothing nearer is known."""
        k = np.flatnonzero(ok & (d >= self.r_min) & (d <= self.r_max) & (d < self.nearest))
        off = [(bearing(v[k]) - self.heading[k] + math.pi) % TAU - math.pi for v in (departs, arrives)]
        sent, received = ((angle / self.half_width[k]) ** 2 for angle in off)
        amplitude = loss(d[k]) * np.exp(-KAPPA * (sent + received)) * rho[k]
        return k[(sent <= 1) & (received <= 1) & (amplitude >= loss(self.r_max[k]) / 1.5)]

    def clear(self, p, q, end):
        """Whether nothing stands between points, but for what touches p or is within `end` of q."""
        low, high = HAIR / length(q - p), 1 - end / length(q - p)
        hits = [t for shape in self.walls + self.arcs for t in shape.meets(p, q - p)]
        return ~np.any([(t > low) & (t < high) for t in hits], axis=0)

    def keep(self, k, d, way, what, end=HAIR):
        """Takes the echoes whose legs are all in sight, the last but for what is within `end` of its end."""
        for leg in range(len(way) - 1):
            if len(k):
                seen = self.clear(way[leg], way[leg + 1], end if leg == len(way) - 2 else HAIR)
                k, way = k[seen], [p[seen] for p in way]
        self.nearest[k] = d[k]
        for reading in k:
            self.what[reading] = what

    def bounce(self, p, image, wall):
        """Where sounds from p towards an image meet the wall, and whether they do, on a free side."""
        (t,) = wall.meets(p, image - p)
        return p + t[:, None] * (image - p), (t > 1e-9) & (t < 1) & wall.faces(p)

    def walls_in_turn(self, events):
        """Closed ways: S mirrored in each wall in turn is T, whence the echo seems to come; d = |ST|/2, ρ = Π ρᵢ."""
        for order in product(range(len(self.walls)), repeat=events):
            turn = [self.walls[k] for k in order]
            # a way and its reverse are one echo; that of a square corner's two walls is the corner's
            square = events == 2 and abs(turn[0].run @ turn[1].run) <= math.sin(SQUARE)
            if order[0] > order[-1] or square or any(p not in self.facing for p in pairwise(order)):
                continue
            images, reverse = [self.at], self.at
            for wall, last in zip(turn, turn[::-1]):
                images.append(wall.image(images[-1]))
                reverse = last.image(reverse)
            departs, arrives = reverse - self.at, images[-1] - self.at
            d, rho = length(arrives) / 2, math.prod(wall.keeps for wall in turn)
            k = self.audible(d, departs, arrives, np.full(len(d), rho), True)
            # backwards from the transducer: each bounce lies on the way to the image before it
            way, ok = [self.at[k]], np.full(len(k), True)
            for wall, image in zip(turn[::-1], images[:0:-1]):
                p, met = self.bounce(way[0], image[k], wall)
                way, ok = [p, *way], ok & met
            way = [self.at[k], *way] if events > 1 else way
            self.keep(k[ok], d, [p[ok] for p in way], "walls " + ", ".join(map(str, order)))

    def reflector(self, at, rho, ok, what, mirror=None, faces=None, end=HAIR):
        """Points, one for each reading, that send sound back the way it came, directly or through a wall, which costs
        its reflection twice; `faces` says from where they answer."""
        wall = None if mirror is None else self.walls[mirror]
        seems = at if wall is None else wall.image(at)
        d = length(seems - self.at)
        k = self.audible(d, seems - self.at, seems - self.at, rho(d) * (1 if wall is None else wall.keeps**2), ok)
        way, ok = [self.at[k], at[k]], np.full(len(k), True)
        if wall is not None and len(k):
            p, ok = self.bounce(self.at[k], seems[k], wall)
            way, ok, what = [way[0], p, way[1]], ok & wall.faces(at[k]), f"{what} through wall {mirror}"
        if faces is not None:
            ok = ok & faces(way[-2])
        self.keep(k[ok], d, [p[ok] for p in way], what, end)

    def corners_and_arcs(self, corners, mirror):
        """Corners and edges, and arcs: of one of radius a the near point, ρ = √(a/(a + d)) from outside, 1 from inside,
        and the far point of one that is hollow or open, ρ = 1; less where the arc isn't smooth."""
        for corner in corners:
            if mirror is None or abs(self.walls[mirror].height(corner.at)) > JOIN:
                at = np.broadcast_to(corner.at, self.at.shape)
                what = f"corner of {math.degrees(corner.opening):.0f}° at {corner.at}"
                # walls that join may overlap by a hair
                self.reflector(at, corner.rho, True, what, mirror, corner.faces, 1.1 * JOIN)
        source = self.at if mirror is None else self.walls[mirror].image(self.at)
        for arc in self.arcs:
            v = source - arc.centre
            for sign in (1, -1):
                at = arc.centre + sign * arc.radius * v / length(v)[:, None]
                bulges = (sign > 0) & (length(v) > arc.radius)

                def rho(d):
                    return np.where(bulges, np.sqrt(arc.radius / (arc.radius + d)), 1) * REFLECTION[arc.surface] / 0.95

                self.reflector(at, rho, arc.answers(at, source), f"arc about {arc.centre}", mirror)

    def rough_surfaces(self):
        """Rough surfaces answer from every place in the beam, ρ = 0.3 times the cosine of the slant."""
        for wall in (w for w in self.walls if w.surface == "diffuse"):
            # the part between the beam's edges, as shares of the wall's length: none where low > high
            low, high = np.zeros(len(self.at)), np.ones(len(self.at))
            for side in (-1, 1):
                edge = towards(self.heading + side * self.half_width)
                a, b = (side * cross(end - self.at, edge) for end in (wall.a, wall.b))
                low = np.where(a < 0, np.maximum(low, a / (a - b)), low)
                high = np.where(b < 0, np.minimum(high, a / (a - b)), high)
            foot = np.clip((self.at - wall.a) @ wall.run / wall.length, low, high)
            for share in [foot, *(low + (high - low) * s for s in np.linspace(0, 1, PLACES))]:
                at = wall.a + share[:, None] * wall.along
                self.rough_places(at, wall.normal, (low < high) & wall.faces(self.at))
        for arc in (a for a in self.arcs if a.surface == "diffuse"):
            v = self.at - arc.centre
            turns = arc.start + arc.sweep * np.linspace(0, 1, 4 * PLACES - 3)
            for normal in [v / length(v)[:, None], *towards(turns)]:
                at = np.broadcast_to(arc.centre + arc.radius * normal, v.shape)
                self.rough_places(at, normal, arc.answers(at, self.at))

    def rough_places(self, at, normal, ok):
        slant = np.abs(((at - self.at) * normal).sum(-1)) / length(at - self.at)
        self.reflector(at, lambda d: SCATTER * slant, ok, "a rough surface")


def main():
    options = argparse.ArgumentParser()
    options.add_argument("world")
    options.add_argument("log")
    options.add_argument("bounces", type=int, choices=(1, 2, 3))
    options.add_argument("--allow", type=float, default=0.0, help="share of the readings that may differ")
    options = options.parse_args()
    with np.errstate(divide="ignore", invalid="ignore"):
        sound = Sound(*read_world(options.world), options.log, options.bounces)
        equal = np.abs(sound.range - sound.nearest) <= TOLERANCE
    neither = np.isinf(sound.range) & np.isinf(sound.nearest)
    differ = np.flatnonzero(~equal & ~neither)
    print(f"{len(equal)} readings, {equal.sum()} equal, {neither.sum()} missing in both, {len(differ)} differ")
    for k in differ[:10]:
        ranges = [f"{z:.4f} m" if np.isfinite(z) else "none" for z in (sound.range[k], sound.nearest[k])]
        pose = f"{sound.at[k]}, heading {sound.heading[k]}"
        print(f"  reading {k + 1} at {pose}: {ranges[0]}, expected {ranges[1]} ({sound.what[k]})")
    sys.exit(len(differ) > options.allow * len(equal))


if __name__ == "__main__":
    main()
