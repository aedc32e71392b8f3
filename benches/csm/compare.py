"""Times `echogrid map` and the numpy/scipy program on the same readings in one run, and prints a table as Markdown.

    python benches/csm/compare.py ECHOGRID FOLDER [RUNS]

ECHOGRID is the release binary, FOLDER holds sample_Intel_dataset.mat and sample_Intel_dataset_semantic.mat. Both are timed end to end
but for the interpreter's start: reading the file, choosing poses and beams, the updates; echogrid also writes its map. Medians.
"""

import json
import statistics
import subprocess
import sys
import tempfile
import time

import counting

CASES = [
    # resolution, scans, and whether the numpy program is run too: it needs minutes for the finest
    (0.5, None, True),
    (0.27, None, True),
    (0.135, None, True),
    (0.135, 372, True),
    (0.135, 186, True),
    (0.05, None, True),
    (0.02, None, False),
]


def cells(resolution):
    """Sample points over 35 m, both ends."""
    return int(35 / resolution + 1e-9) + 2 if abs(35 / resolution % 1) > 1e-9 else int(35 / resolution + 1.5)


def main(echogrid, folder, runs=3):
    print("| method | cells | scans | echogrid, s | numpy/scipy, s | times | occupied | free | numpy's |")
    print("|---|---|---|---|---|---|---|---|---|")
    for resolution, scans, both in CASES:
        for name in ["csm-discrete", "csm-continuous", "csm-semantic-discrete", "csm-semantic-continuous"]:
            semantic = "semantic" in name
            file = f"{folder}/sample_Intel_dataset{'_semantic' if semantic else ''}.mat"
            n = cells(resolution)
            low, half = (-15.0, -25.0), resolution / 2
            ends = [low[0] - half, low[1] - half, low[0] - half + n * resolution, low[1] - half + n * resolution]
            poses, points = counting.load(file, scans)
            until = sum(scan.shape[1] for scan in points)
            ours, theirs = [], []
            with tempfile.TemporaryDirectory() as place:
                command = [echogrid, "map", file, "-o", f"{place}/map", "--method", name, "--backend", "cpu", "--json"]
                command += ["--resolution", str(resolution), "--bounds=" + ",".join(map(repr, ends)), "--until", str(until)]
                for run in range(runs):
                    started = time.perf_counter()
                    report = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
                    ours.append(time.perf_counter() - started)
                    if both and run == 0:
                        started = time.perf_counter()
                        poses, points = counting.load(file, scans)
                        labels = 6 if semantic else 1
                        alpha = counting.count(poses, points, low, n, resolution, "continuous" in name, labels)
                        theirs.append(time.perf_counter() - started)
            assert report["cells"]["width"] == n, (report["cells"], n)
            gains = report["increments"]
            sums = f"{sum(gains[:-1]):.6g} | {gains[-1]:.8g}"
            mine = statistics.median(ours)
            other = "- | - " if not both else f"{theirs[0]:.2f} | {theirs[0] / mine:.0f} "
            check = "-" if not both else f"{alpha[:, :-1].sum():.6g}, {alpha[:, -1].sum():.8g}"
            print(f"| {name} | {n} × {n} of {resolution} m | {len(poses)} | {mine:.2f} | {other}| {sums} | {check} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], *map(int, sys.argv[3:]))
