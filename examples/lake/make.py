#!/usr/bin/env python3
"""Writes FOLDER/lake_bed.asc: a basin with bumps beneath the water, pixels of 0.5 m."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "scripts"))
from maps import write_ascii  # noqa: E402


def main(folder):
    x, y = np.arange(-0.5, 40.6, 0.5), np.arange(-0.5, 12.6, 0.5)
    X, Y = np.meshgrid(x, y)
    bumps = 0.2 * np.sin(0.9 * X) * np.cos(0.7 * Y) * np.exp(-(((X - 20) / 4) ** 4))
    write_ascii(Path(folder) / "lake_bed.asc", x, y, 0.02 * (X - 20) ** 2 + bumps)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "out")
