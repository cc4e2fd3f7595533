#!/usr/bin/env python3
"""The points of a quadrant of a sphere with the stress at the start: python3 points.py > points.csv, which case.yaml reads.

Places and areas are those of ../cavity_expansion/points.py; the volume is that of a full turn.
"""
import argparse
import runpy
from pathlib import Path

import numpy as np

RING = runpy.run_path(str(Path(__file__).resolve().parent.parent / "cavity_expansion" / "points.py"))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, default=2, help="cells to a radius of the cavity (2)")
    options = parser.parse_args()
    size = RING["RADIUS"] / (3 * options.cells)
    points = RING["squares"](size)
    RING["merge"](points, size)
    print("x,y,volume,stress_xx,stress_yy,stress_zz,stress_xy")
    for _, (area, place) in sorted(points.items()):
        volume = 2.0 * np.pi * place[0] * area
        print(f"{place[0]:.10g},{place[1]:.10g},{volume:.10g}" + 3 * f",{-RING['PRESSURE']:.0f}" + ",0")


if __name__ == "__main__":
    main()
