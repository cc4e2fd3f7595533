#!/usr/bin/env python3
"""Writes grains.raw and grains.mhd: grains (2) and voids (0) in a binder (1), spheres in a cube of 24 x 24 x 24 voxels.

Centres, over the side of the cube, are frac(1/2 + k (g, g^2, g^3)) with g = 1/1.22074..., 1/g the root of x^4 = x + 1
(additive sequence of low discrepancy): k = 1 to 24 for grains of radius 0.16, 25 to 36 for voids of radius 0.07.
Voids cut grains.
"""
from pathlib import Path

import numpy as np

SIZE = 24
G = 1.0 / 1.22074408460575947536

place = (np.arange(SIZE) + 0.5) / SIZE
z, y, x = np.meshgrid(place, place, place, indexing="ij")
label = np.ones((SIZE, SIZE, SIZE), dtype="u1")
for k in range(1, 37):
    centre = np.modf(0.5 + k * np.array([G, G**2, G**3]))[0]
    distance = np.sqrt((x - centre[0]) ** 2 + (y - centre[1]) ** 2 + (z - centre[2]) ** 2)
    if k <= 24:
        label[distance < 0.16] = 2
    else:
        label[distance < 0.07] = 0
folder = Path(__file__).parent
label.tofile(folder / "grains.raw")
(folder / "grains.mhd").write_text(f"ObjectType = Image\nNDims = 3\nDimSize = {SIZE} {SIZE} {SIZE}\nElementType = MET_UCHAR\n"
                                   "ElementDataFile = grains.raw\n")
