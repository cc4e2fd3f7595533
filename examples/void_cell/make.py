#!/usr/bin/env python3
"""Writes cell.geojson: the unit square with a round hole of radius 1/4, as a polygon of 240 corners and the same area."""
import json
import math
from pathlib import Path

CORNERS = 240
radius = 0.25 * math.sqrt(2.0 * math.pi / CORNERS / math.sin(2.0 * math.pi / CORNERS))
angles = [2.0 * math.pi * (k + 0.5) / CORNERS for k in range(CORNERS)]
hole = [[round(0.5 + radius * math.cos(a), 9), round(0.5 + radius * math.sin(a), 9)] for a in angles]
square = [[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]
Path(__file__).with_name("cell.geojson").write_text(json.dumps(
    {"type": "FeatureCollection", "features": [
        {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [square, hole + hole[:1]]}}]}) + "\n")
