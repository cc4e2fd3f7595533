#!/usr/bin/env python3
"""A mud flow over a road and past a house: volumes at the road and on the fan, reach, end at rest."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402
from maps import read_map  # noqa: E402

ROAD = 520.0  # m


def check(results):
    peak, state, history = read_map(f"{results.prefix}_peak"), results.state("last"), results.history
    pixel = (peak.x[1] - peak.x[0]) * (peak.y[1] - peak.y[0])
    volume, x = state["volume"].ravel(), state["position"][:, 0]
    reach = results.summary["runout"]
    return [completed(results),
            Quantity.near("deposit_over_volume", np.nansum(peak.bands["deposit"]) * pixel / volume.sum(), 1.0, relative=0.01),
            Quantity.near("passed_over_beyond", history["gauge_road_volume"][-1] / volume[x > ROAD].sum(), 1.0, relative=0.05),
            Quantity.near("house_pressure_over_map", history["gauge_house_pressure"][-1] / np.nanmax(
                peak.bands["pressure"][np.ix_((peak.y >= 110) & (peak.y <= 125), (peak.x >= 530) & (peak.x <= 545))]), 1.0, relative=0.15),
            Quantity("way", reach["gully"]["way"], 470.0, 580.0),
            Quantity("angle", reach["gully"]["angle"], 18.0, 21.5),
            Quantity("rest", reach.get("rest", 0.0), 30.0, 80.0)]


def draw(results):
    from argparse import Namespace

    from pictures.terrain import plot_terrain

    return plot_terrain(results, None, Namespace(step="last", field="depth", colours=None, limits=None, plain=False, title=None))


if __name__ == "__main__":
    common.main(check, draw)
