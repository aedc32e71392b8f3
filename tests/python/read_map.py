"""Reads the map that tests/output/python.rs has written, as a user would, and checks it.

The pattern is that of tests/output/common.rs: cells of 0.5 m from (-2, 1), one occupied cell in column 2, row 6, row 1
empty, the rest untouched.
"""

import sys
from pathlib import Path

import numpy as np
import xarray as xr
import zarr

folder = Path(sys.argv[1])
store = folder / "map.zarr"
width, height = 1500, 1100

group = zarr.open_group(store, mode="r")
assert group.metadata.zarr_format == 3
assert sorted(group.array_keys()) == ["class", "count", "log_odds", "p_occ", "touched", "x", "y"]
attributes = dict(group.attrs)
assert attributes["method"] == "bayes"
assert attributes["parameters"] == {"model": "murphy", "max_occ": 0.98}
assert attributes["log_sha256"] == "ab" * 32
assert attributes["resolution"] == 0.5 and attributes["anchor"] == [0.0, 0.0]
assert attributes["layers"] == ["log_odds", "p_occ", "count", "touched", "class"]
assert attributes["version"]

array = group["log_odds"]
assert array.shards == (1024, 1024) and array.chunks == (256, 256)
assert array.metadata.dimension_names == ("y", "x")
for name, kind, fill in [
    ("log_odds", "float32", 0.0),
    ("p_occ", "float32", 0.5),
    ("count", "uint32", 0),
    ("touched", "uint8", 0),
    ("class", "int8", 0),
]:
    assert group[name].dtype == np.dtype(kind), name
    assert group[name].fill_value == fill, name
    assert group[name].shape == (height, width), name

data = xr.open_zarr(store, consolidated=False)
assert data.sizes == {"y": height, "x": width}
x, y = data["x"].values, data["y"].values
assert x.dtype == np.float64 and x[0] == -1.75 and y[0] == 1.25
assert np.array_equal(np.diff(x), np.full(width - 1, 0.5)), "x ascends by one cell"
assert np.array_equal(np.diff(y), np.full(height - 1, 0.5)), "y ascends by one cell"
assert data["x"].attrs["units"] == "m"
assert array.attrs["colour_range"] == [-3.0, 3.0] and "valid_range" not in array.attrs

# (-0.75, 4.25) is the centre of column 2, row 6.
near = {"x": -0.8, "y": 4.3, "method": "nearest"}
assert data["class"].sel(**near).item() == 1
assert data["log_odds"].sel(**near).item() == 1.5
assert data["count"].sel(**near).item() == 70_000
assert data["class"].sel(x=700.0, y=1.8, method="nearest").item() == -1
assert data["p_occ"].sel(x=100.0, y=500.0, method="nearest").item() == 0.5, "an unstored chunk reads as its fill"
assert data["class"].dtype == np.int8 and data["touched"].dtype == np.uint8
assert int((data["class"] == 1).sum()) == 1 and int((data["class"] == -1).sum()) == width
assert int(data["touched"].sum()) == width + 1

for name in attributes["layers"]:
    plain = np.load(folder / f"{name}.npy")
    assert plain.dtype == group[name].dtype, name
    assert np.array_equal(plain, group[name][:]), name

print("read_map.py: all right")
