#!/usr/bin/env python3
"""A rock slide in a real valley: volume of its deposit, speed by energy, reach."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402
from maps import read_map  # noqa: E402

G = 9.81


def check(results):
    peak, state = read_map(f"{results.prefix}_peak"), results.state("last")
    pixel = (peak.x[1] - peak.x[0]) * (peak.y[1] - peak.y[0])
    volume, reach = state["volume"].sum(), results.summary["runout"]
    drop = results.initial["bed"].max() + 10.0 - state["bed"].min()
    return [completed(results),
            Quantity.near("deposit_over_volume", np.nansum(peak.bands["deposit"]) * pixel / volume, 1.0, relative=0.01),
            Quantity("speed_over_free_fall", np.nanmax(peak.bands["speed"]) / np.sqrt(2.0 * G * drop), 0.25, 1.0),
            Quantity("way", reach["reach"]["way"], 2000.0, 2600.0),
            Quantity("angle", reach["reach"]["angle"], 10.0, 14.0),
            Quantity("rest", reach.get("rest", 0.0), 100.0, 200.0)]


def draw(results):
    from argparse import Namespace

    from pictures.terrain import plot_terrain

    return plot_terrain(results, None, Namespace(step="last", field="depth", colours=None, limits=None, plain=False, title=None))


if __name__ == "__main__":
    common.main(check, draw)
