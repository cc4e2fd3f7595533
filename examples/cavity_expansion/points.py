#!/usr/bin/env python3
"""The points of a quarter of a ring with the stress at the start: python3 points.py > points.csv, which case.yaml reads.

They lie in a lattice. A point whose square is cut by the wall or the rim has the area that is left of it and stands at its
centroid, so that areas and first moments are those of the ring and the stress at the start is in balance. A sliver, less than
a fifth of a square, is no point: the next square away from the circle takes it.
"""
import argparse

import numpy as np

RADIUS, RIM, PRESSURE = 1.0, 10.0, 100e3  # m, m, Pa
STRIPS = 200  # of a square that is cut
SLIVER = 0.2  # of a square: the least area of a point


def clipped(left, bottom, size, rim):
    """Area and centroid of the part of a square between the two circles, by strips along x."""
    x = left + (np.arange(STRIPS) + 0.5) * size / STRIPS
    low = np.clip(np.sqrt(np.maximum(RADIUS**2 - x**2, 0.0)), bottom, bottom + size)
    high = np.clip(np.sqrt(np.maximum(rim**2 - x**2, 0.0)), bottom, bottom + size)
    height = np.maximum(high - low, 0.0)
    area = height.sum() * size / STRIPS
    if area <= 0.0:
        return 0.0, (0.0, 0.0)
    return area, (np.sum(height * x) / height.sum(), np.sum(height * (high + low) / 2.0) / height.sum())


def squares(size, rim=RIM):
    """Area and centroid of what the ring has of each square, by its place in the lattice."""
    points, count = {}, round(rim / size)
    for i in range(count):
        for j in range(count):
            left, bottom = i * size, j * size
            near, far = np.hypot(left, bottom), np.hypot(left + size, bottom + size)
            if far <= RADIUS or near >= rim:
                continue
            area, place = size**2, (left + size / 2.0, bottom + size / 2.0)
            if near < RADIUS or far > rim:
                area, place = clipped(left, bottom, size, rim)
            if area > 0.0:
                points[i, j] = (area, np.array(place))
    return points


def merge(points, size, rim=RIM):
    """Puts slivers into the next square away from the wall or the rim, along the axis that is nearer to the radius, or both."""
    for i, j in sorted(points, key=lambda square: points[square][0]):
        area, place = points[i, j]
        if area >= SLIVER * size**2:
            return
        away = 1 if np.hypot(*place) < (RADIUS + rim) / 2.0 else -1
        across = abs(place[0] - place[1]) < 1e-9
        other = (i + away * (across or place[0] > place[1]), j + away * (across or place[0] < place[1]))
        if other not in points:
            other = (i + away, j + away)
        total = area + points[other][0]
        points[other] = (total, (area * place + points[other][0] * points[other][1]) / total)
        del points[i, j]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, default=2, help="cells to a radius of the cavity (2)")
    parser.add_argument("--per-cell", type=int, default=3, help="points to a cell along an axis (3)")
    options = parser.parse_args()
    size = RADIUS / (options.cells * options.per_cell)
    stress = 3 * f",{-PRESSURE:.0f}" + ",0"
    print("x,y,volume,stress_xx,stress_yy,stress_zz,stress_xy")
    points = squares(size)
    merge(points, size)
    for _, (area, place) in sorted(points.items()):
        print(f"{place[0]:.10g},{place[1]:.10g},{area:.10g}{stress}")


if __name__ == "__main__":
    main()
