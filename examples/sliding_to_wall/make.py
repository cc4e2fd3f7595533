#!/usr/bin/env python3
"""Writes FOLDER/sliding_bed.asc: a slope of 1 in 3 down to level ground at x = 10 m, pixels of 0.25 m.

And FOLDER/sliding_depth.asc: the depths of all of the water at rest before a wall at x = 20 m.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "scripts"))
from maps import write_ascii  # noqa: E402

AREA = 2.0416667  # m2: of the water in section
DEPTH = (np.sqrt(100 + 6 * AREA) - 10) / 3  # m, at rest: 10 h + 1.5 h^2 is the area


def bed(x):
    return np.maximum(10 - x / 3, 10 - 10 / 3)


def main(folder):
    x, y = np.arange(-0.5, 41.0, 0.25), np.arange(-0.5, 1.1, 0.25)
    write_ascii(Path(folder) / "sliding_bed.asc", x, y, np.tile(bed(x), (len(y), 1)))
    x, y = np.arange(8.953125, 20.2, 0.03125), np.arange(-0.03125, 0.2, 0.0625)
    write_ascii(Path(folder) / "sliding_depth.asc", x, y, np.tile(np.where(x < 20, 10 - 10 / 3 + DEPTH - bed(x), -9.0), (len(y), 1)))


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "out")
