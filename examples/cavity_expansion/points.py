#!/usr/bin/env python3
"""The points of a quarter of a ring with the stress at the start: python3 points.py > points.csv, which case.yaml reads.

They lie in a lattice. A point whose square is cut by the wall or the rim has the area that is left of it and stands at its
centroid, so that areas and first moments are those of the ring and the stress at the start is in balance.
"""
import argparse

import numpy as np

RADIUS, RIM, PRESSURE = 1.0, 10.0, 100e3  # m, m, Pa
STRIPS = 200  # of a square that is cut


def clipped(left, bottom, size):
    """Area and centroid of the part of a square between the two circles, by strips along x."""
    x = left + (np.arange(STRIPS) + 0.5) * size / STRIPS
    low = np.clip(np.sqrt(np.maximum(RADIUS**2 - x**2, 0.0)), bottom, bottom + size)
    high = np.clip(np.sqrt(np.maximum(RIM**2 - x**2, 0.0)), bottom, bottom + size)
    height = np.maximum(high - low, 0.0)
    area = height.sum() * size / STRIPS
    if area <= 0.0:
        return 0.0, (0.0, 0.0)
    return area, (np.sum(height * x) / height.sum(), np.sum(height * (high + low) / 2.0) / height.sum())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, default=2, help="cells to a radius of the cavity (2)")
    parser.add_argument("--per-cell", type=int, default=2, help="points to a cell along an axis (2)")
    options = parser.parse_args()
    size = RADIUS / (options.cells * options.per_cell)
    count = round(RIM / size)
    stress = 3 * f",{-PRESSURE:.0f}" + ",0"
    print("x,y,volume,stress_xx,stress_yy,stress_zz,stress_xy")
    for i in range(count):
        for j in range(count):
            left, bottom = i * size, j * size
            near, far = np.hypot(left, bottom), np.hypot(left + size, bottom + size)
            if far <= RADIUS or near >= RIM:
                continue
            area, place = size**2, (left + size / 2.0, bottom + size / 2.0)
            if near < RADIUS or far > RIM:
                area, place = clipped(left, bottom, size)
            if area < 1e-6 * size**2:
                continue
            print(f"{place[0]:.10g},{place[1]:.10g},{area:.10g}{stress}")


if __name__ == "__main__":
    main()
