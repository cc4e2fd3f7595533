#!/usr/bin/env python3
"""Writes release.asc: the vertical depth of a parabolic cap on a slope of 30 degrees, H = 2 m and 2 L = 120 m along it."""
import math
from pathlib import Path

C, HEIGHT, HALF, PIXEL = math.cos(math.radians(30)), 2.0, 60.0, 0.5
COLUMNS = 2 * math.ceil(HALF * C / PIXEL) + 3


def depth(x):
    """Normal depth H (1 - (s/L)^2) at s = x/cos, as a vertical one."""
    return max(HEIGHT * (1.0 - (x / C / HALF) ** 2), 0.0) / C


def main():
    row = " ".join(f"{depth((k - COLUMNS // 2) * PIXEL):.9g}" for k in range(COLUMNS))
    head = f"ncols {COLUMNS}\nnrows 2\nxllcenter {-(COLUMNS // 2) * PIXEL}\nyllcenter -5\ndx {PIXEL}\ndy 20\n"
    Path(__file__).with_name("release.asc").write_text(head + f"{row}\n{row}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
