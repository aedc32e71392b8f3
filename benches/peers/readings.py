#!/usr/bin/env python3
"""Makes the seeded readings of the comparison, each workload as text for peers.cpp and as an echogrid log.

    readings.py FOLDER

Writes cone-5m, sonar-5m, sonar-2m and laser-10m, each as .txt (a line a reading: x y heading range) and .jsonl; few-5m is
every hundredth reading of sonar-5m.
"""
import json
import math
import os
import random
import sys

EDGE = 51.2  # m: 1024 cells of 5 cm
READINGS = 20_000
SCANS = 100
BEAMS = 361
SONAR = {
    "id": "cone", "kind": "sonar", "half_width": "15deg", "r_min": 0.1, "r_max": 5, "hit_range": 5,
    "no_echo_range": 0,
}
LASER = {
    "id": "beam", "kind": "laser", "half_width": "0.25deg", "r_min": 0.1, "r_max": 20, "hit_range": 20,
    "no_echo_range": 0,
}


def sonar(seed, nearest, farthest):
    """Scans of one reading each, anywhere on the map in any direction: position, then pairs of heading and range."""
    dice = random.Random(seed)
    for _ in range(READINGS):
        x, y = dice.uniform(0, EDGE), dice.uniform(0, EDGE)
        yield x, y, [(dice.uniform(0, math.tau), dice.uniform(nearest, farthest))]


def laser(seed, nearest, farthest):
    """Scans of half a turn, from the right to the left."""
    dice = random.Random(seed)
    for _ in range(SCANS):
        x, y, middle = dice.uniform(0, EDGE), dice.uniform(0, EDGE), dice.uniform(0, math.tau)
        step = math.pi / (BEAMS - 1)
        yield x, y, [(middle + (k - BEAMS // 2) * step, dice.uniform(nearest, farthest)) for k in range(BEAMS)]


def write(stem, sensor, scans):
    with open(stem + ".txt", "w") as text, open(stem + ".jsonl", "w") as log:
        log.write(json.dumps({"echogrid_log": 1, "sensors": [sensor]}) + "\n")
        for number, (x, y, beams) in enumerate(scans):
            x, y = round(x, 4), round(y, 4)
            for heading, z in beams:
                heading, z = round(heading, 6), round(z, 4)
                text.write(f"{x} {y} {heading} {z}\n")
                record = {"t": float(number), "scan": number, "sensor": 0, "px": x, "py": y, "ph": heading}
                log.write(json.dumps(record | {"x": x, "y": y, "h": heading, "z": z}) + "\n")


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: readings.py FOLDER")
    folder = sys.argv[1]
    os.makedirs(folder, exist_ok=True)
    write(os.path.join(folder, "cone-5m"), SONAR, sonar(4, 5, 5))
    write(os.path.join(folder, "sonar-5m"), SONAR, sonar(1, 1, 5))
    write(os.path.join(folder, "few-5m"), SONAR, list(sonar(1, 1, 5))[::100])
    write(os.path.join(folder, "sonar-2m"), SONAR, sonar(2, 1, 2))
    write(os.path.join(folder, "laser-10m"), LASER, laser(3, 9, 10))


if __name__ == "__main__":
    main()
