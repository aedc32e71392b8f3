#!/usr/bin/env python3
"""Prints the tables of the comparison from what `run` left in a folder: ROUND,WORKLOAD,PROGRAM.json.

    table.py FOLDER LOAD
"""
import collections
import json
import os
import statistics
import sys

WORKLOADS = {
    "cone-5m": "sonar, 30° cones, 5 m",
    "sonar-5m": "sonar, 30° cones, 1–5 m",
    "sonar-2m": "sonar, 30° cones, 1–2 m",
    "laser-10m": "laser, 361 beams, 9–10 m",
}
PEERS = {
    "mrpt-cone": ("MRPT", "a triangle of one value, a line of another at its end"),
    "mrpt-scan": ("MRPT", "a line for each beam"),
    "octomap-ray": ("OctoMap, one ray", "the axis alone"),
    "octomap-fan": ("OctoMap, fan", "rays over the cone, a cell apart at the arc"),
    "octomap-scan": ("OctoMap", "a ray for each beam"),
}
METHODS = {
    "bayes": "full profile of the cone",
    "dempster-shafer": "full profile of the cone",
    "certainty": "full profile of the cone, each reading's occupied part normalised",
    "himm": "the axis alone",
}
BASE = ("cpu", 1, "bayes")


class Timed:
    """Seconds of every pass of one program over one workload, by round."""

    def __init__(self):
        self.seconds, self.readings, self.cells = collections.defaultdict(list), 0, 0.0

    def add(self, number, seconds, readings, cells):
        self.seconds[number] += seconds
        self.readings, self.cells = readings, cells

    def every(self):
        return [s for passes in self.seconds.values() for s in passes]

    def median(self):
        return self.readings / statistics.median(self.every())

    def best(self):
        return self.readings / min(self.every())


def read(folder):
    """What was timed, by workload and by program (a peer's name, or backend, threads, method), and who took part."""
    timed, versions, adapters = collections.defaultdict(Timed), set(), {}
    for file in sorted(os.listdir(folder)):
        number, workload, program = file.removesuffix(".json").split(",")
        with open(os.path.join(folder, file)) as text:
            found = json.load(text)
        if program in PEERS:
            versions.add(found["version"])
            timed[workload, program].add(number, found["seconds"], found["readings"], found["cells"])
            continue
        _, backend, threads = program.split("-")
        versions.add(f"echogrid {found['version']}")
        for one in found["backends"]:
            adapters[backend] = one["adapter"].split(" threads, ")[-1]
        for m in found["measured"]:
            if m["workload"].startswith(workload):
                key = (backend, int(threads), m["method"])
                timed[workload, key].add(number, m["seconds"], m["readings"], m["updates"] / m["readings"])
    return timed, versions, adapters


def processor():
    try:
        with open("/proc/cpuinfo") as lines:
            return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return "unknown processor"


def row(*cells):
    print("| " + " | ".join(str(cell) for cell in cells) + " |")


def head(*cells):
    row(*cells)
    print("|" + "---|" * len(cells))


def title(program):
    """Program, threads, what it computes."""
    if program in PEERS:
        name, what = PEERS[program]
        return name, "1", what
    backend, threads, method = program
    return f"echogrid {method}", "GPU" if backend == "gpu" else threads, METHODS[method]


def ratio(ours, theirs):
    """Speed over speed: the median, the least and the most of the rounds in which both ran."""
    of_rounds = [
        statistics.median(theirs.seconds[n]) / theirs.readings * ours.readings / statistics.median(ours.seconds[n])
        for n in list(ours.seconds)
        if n in theirs.seconds
    ]
    return statistics.median(of_rounds), min(of_rounds), max(of_rounds)


def short(number):
    return f"{number:.1f}" if number >= 1 else f"{number:.2f}" if number >= 0.1 else f"{number:.3f}"


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: table.py FOLDER LOAD")
    timed, versions, adapters = read(sys.argv[1])
    programs = list(PEERS) + sorted(
        {p for _, p in timed if p not in PEERS}, key=lambda p: (p[0], p[1], list(METHODS).index(p[2]))
    )
    rounds = len(timed["sonar-5m", BASE].seconds)

    print("# MRPT and OctoMap beside echogrid\n")
    kernels = "; ".join(f"{backend}: {adapter}" for backend, adapter in adapters.items())
    print(f"{', '.join(sorted(versions))}; {processor()}, {os.cpu_count()} cores, load {sys.argv[2]} at the start;")
    print(f"echogrid's kernels: {kernels}.")
    empty = timed["few-5m", BASE]
    alone = 1e3 * statistics.median(empty.every())
    print(f"Cells of 5 cm; {rounds} rounds, the programs in turn.\n")
    print("The machine may be shared with other work: **only the ratios count**, not the speeds. A pass of echogrid")
    print(f"includes making its empty map ({alone:.0f} ms with {empty.readings} readings); MRPT's is made beforehand.")
    print("Cells a reading: of echogrid the updates; of the peers the cells that one reading or scan touches, each once.\n")
    speeds = ("k readings/s, median", "best", "× bayes on one thread")
    head("program", "threads", "what it computes", "workload", "cells a reading", *speeds)
    for workload, name in WORKLOADS.items():
        base = timed[workload, BASE]
        for program in programs:
            if (workload, program) not in timed:
                continue
            t = timed[workload, program]
            speeds = (f"{t.median() / 1e3:.1f}", f"{t.best() / 1e3:.1f}", short(ratio(t, base)[0]))
            row(*title(program), name, f"{t.cells:.0f}", *speeds)

    print("\n## echogrid / peer\n")
    print("Readings/s of echogrid over those of the peer, each round by itself: the median of the rounds, in brackets")
    print("the least and the most. Above 1 echogrid is faster; where it is slower, the ratio is in bold.\n")
    slower = []
    peers = [(w, p) for w in WORKLOADS for p in PEERS if (w, p) in timed]
    head("echogrid", "threads", *(f"{PEERS[p][0]}; {WORKLOADS[w]}" for w, p in peers))
    for ours in programs[len(PEERS) :]:
        name, threads, _ = title(ours)
        cells = []
        for workload, peer in peers:
            if (workload, ours) not in timed:
                cells.append("-")
                continue
            middle, least, most = ratio(timed[workload, ours], timed[workload, peer])
            mark = "**" if middle < 1 else ""
            cells.append(f"{mark}{short(middle)}{mark} ({short(least)}–{short(most)})")
            if middle < 1 and ours[:2] == BASE[:2]:
                times = f"{PEERS[peer][0]} takes {1 / middle:.1f} times as many readings/s"
                slower.append(f"{name}: {times} ({WORKLOADS[workload]})")
        row(name.removeprefix("echogrid "), threads, *cells)

    print("\nOn one thread echogrid is slower in:\n" if slower else "\nOn one thread echogrid is slower nowhere.")
    for line in slower:
        print(f"- {line}")


if __name__ == "__main__":
    main()
