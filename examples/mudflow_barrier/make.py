#!/usr/bin/env python3
"""Writes FOLDER/barrier_bed.asc: a straight gully that opens on a fan, pixels of 5 m."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "scripts"))
from maps import gully_on_fan, write_ascii  # noqa: E402

FAN, MIDDLE = 300.0, 100.0  # m: where the slope ends, and y of the gully


def bed(x, y):
    return gully_on_fan(x, y, FAN, MIDDLE, (0.4, 0.06), 30.0, ends=25.0, depth=15.0, width=35.0)


def main(folder):
    x, y = np.arange(-5.0, 605.1, 5.0), np.arange(-5.0, 205.1, 5.0)
    write_ascii(Path(folder) / "barrier_bed.asc", x, y, bed(*np.meshgrid(x, y)))


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "out")
