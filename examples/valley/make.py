#!/usr/bin/env python3
"""Writes FOLDER/valley_bed.asc and FOLDER/valley_depth.asc: real ground of degrees, brought to metres, and a slab on it.

The ground is `jacksboro_fault_dem.npz` of matplotlib's sample data (Debian: python-matplotlib-data), SRTM heights in
metres. About its middle, degrees become metres by the radii of curvature of WGS 84.
"""
import sys
from pathlib import Path

import matplotlib
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "scripts"))
from maps import write_ascii  # noqa: E402

DATA = "sample_data/jacksboro_fault_dem.npz"
AXIS, SQUARE = 6378137.0, 0.00669437999014  # of WGS 84: half the long axis, m, and the square of the eccentricity
PIXEL = 30.0
LOWER, UPPER = (15600.0, 1800.0), (19800.0, 4200.0)  # m from the south-west corner: the part that is used
RELEASE, RADIUS, THICK = (16650.0, 2970.0), 300.0, 10.0  # m


def ground():
    """Places and heights on the file's pixels, m from the south-west corner; rows from south to north."""
    with np.load(Path(matplotlib.get_data_path()) / DATA) as data:
        height, degrees = data["elevation"].astype(float)[::-1], [float(data[name]) for name in ("xmin", "ymin", "dx", "dy", "ymax")]
    _, south, dx, dy, north = degrees
    middle = np.radians(0.5 * (south + north))
    root = np.sqrt(1.0 - SQUARE * np.sin(middle) ** 2)
    east = np.radians(dx) * AXIS / root * np.cos(middle)
    north = np.radians(dy) * AXIS * (1.0 - SQUARE) / root**3
    return np.arange(height.shape[1]) * east, np.arange(height.shape[0]) * north, height


def resample(x, y, value, to_x, to_y):
    """Bilinear between pixels."""
    rows = np.array([np.interp(to_x, x, row) for row in value])
    return np.array([np.interp(to_y, y, column) for column in rows.T]).T


def main(folder):
    x, y, height = ground()
    to_x, to_y = (np.arange(low - PIXEL, high + 1.5 * PIXEL, PIXEL) for low, high in zip(LOWER, UPPER))
    bed = resample(x, y, height, to_x, to_y)
    r = np.hypot(to_x - RELEASE[0], (to_y - RELEASE[1])[:, None])
    write_ascii(Path(folder) / "valley_bed.asc", to_x, to_y, bed)
    write_ascii(Path(folder) / "valley_depth.asc", to_x, to_y, THICK * np.clip(1.0 - (r / RADIUS) ** 2, 0.0, None))


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "out")
