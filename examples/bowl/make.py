#!/usr/bin/env python3
"""Writes FOLDER/bowl_bed.asc and FOLDER/bowl_depth.asc: Thacker's paraboloid and its water at first, pixels of 0.25 m."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "scripts"))
from maps import write_ascii  # noqa: E402
sys.path.insert(0, str(Path(__file__).resolve().parent))
from check import RADIUS, depth  # noqa: E402


def main(folder):
    x = np.arange(-14.5, 14.6, 0.25)
    r = np.hypot(*np.meshgrid(x, x))
    write_ascii(Path(folder) / "bowl_bed.asc", x, x, (r / RADIUS) ** 2)
    write_ascii(Path(folder) / "bowl_depth.asc", x, x, np.maximum(depth(r, 0.0), 0.0))


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "out")
