"""The counting sensor models as a straightforward numpy/scipy program: what `echogrid map` is timed beside.

For each cell the 16 nearest poses by a k-d tree; scan by scan the nearest beam in bearing by an argmin over all beams; then the update,
in f64. Nothing is tuned, nothing is written.
"""

import numpy as np
import scipy.io
from scipy.spatial import cKDTree

PRIOR, Z_MAX, W_BEAM, L, SIGMA0 = 0.001, 30.0, 2 * np.pi / 133, 0.2, 0.1


def load(path, until=None):
    """Poses (n, 3), and for each scan 2 × N or 3 × N points in the robot's frame; of the first `until` scans."""
    file = scipy.io.loadmat(path)
    pose = file["robotPose"][0, 0]
    poses = np.column_stack([pose[k].ravel() for k in "xyh"])
    return poses[:until], list(file["laserScan"].ravel()[:until])


def kernel(d):
    t = d / L
    k = SIGMA0 * ((2 + np.cos(2 * np.pi * t)) / 3 * (1 - t) + np.sin(2 * np.pi * t) / (2 * np.pi))
    return np.where(t < 1, np.maximum(k, 0), 0)


def count(poses, scans, low, cells, resolution, continuous, labels=1, neighbours=16):
    """Increments of α, (cells², labels + 1), row by row; sample points at `low` + k · `resolution`."""
    x = low[0] + resolution * np.arange(cells)
    y = low[1] + resolution * np.arange(cells)
    points = np.column_stack([grid.ravel() for grid in np.meshgrid(x, y)])
    _, nearest = cKDTree(poses[:, :2]).query(points, min(neighbours, len(poses)))
    alpha = np.zeros((len(points), labels + 1))
    for k, ((px, py, heading), scan) in enumerate(zip(poses, scans)):
        cell, _ = np.nonzero(nearest == k)
        if len(cell) == 0:
            continue
        z, bearing = np.hypot(scan[0], scan[1]), np.arctan2(scan[1], scan[0])
        label = scan[2].astype(int) - 1 if labels > 1 else np.zeros(len(z), int)
        dx, dy = points[cell, 0] - px, points[cell, 1] - py
        d = np.hypot(dx, dy)
        off = np.abs((np.arctan2(dy, dx) - heading)[:, None] - bearing[None])
        off = np.abs((off + np.pi) % (2 * np.pi) - np.pi)
        beam = off.argmin(1)
        off, z, bearing, label = off[np.arange(len(cell)), beam], z[beam], bearing[beam], label[beam]
        seen = (d > 0) & (d < Z_MAX)
        if continuous:
            ux, uy = np.cos(heading + bearing), np.sin(heading + bearing)
            along, across = dx * ux + dy * uy, np.abs(dx * uy - dy * ux)
            seen &= along >= 0
            free = seen & (along <= z)
            np.add.at(alpha, (cell[seen], label[seen]), kernel(np.hypot(dx - z * ux, dy - z * uy))[seen])
            np.add.at(alpha, (cell[free], np.full(free.sum(), labels)), kernel(across)[free])
        else:
            seen &= (d <= np.minimum(Z_MAX, z + resolution)) & (off <= W_BEAM / 2) & (z < Z_MAX)
            hit = seen & (np.abs(d - z) < resolution)
            free = seen & ~hit & (d < z)
            np.add.at(alpha, (cell[hit], label[hit]), 1)
            np.add.at(alpha, (cell[free], np.full(free.sum(), labels)), 1)
    return alpha
