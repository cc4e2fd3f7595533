#!/usr/bin/env python3
"""A torrent that grows along its path: balance of mass, growth, depth of erosion, deposit on the fan, maps against columns."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402
from maps import read_map  # noqa: E402

GROUND, FAN, DEEPEST = 2000.0, 420.0, 1.5  # kg/m3, m, m


def check(results):
    peak, history = read_map(f"{results.prefix}_peak"), results.history
    pixel = (peak.x[1] - peak.x[0]) * (peak.y[1] - peak.y[0])
    last = {name: history[name][-1] for name in ("mass", "mass_in", "mass_out", "mass_eroded", "mass_deposited")}
    change = peak.bands["bed_change"]
    left = last["mass_in"] - last["mass_out"] + last["mass_eroded"] - last["mass_deposited"]
    risen = np.where(change > 0.0, change, 0.0)
    return [completed(results),
            Quantity("mass_in", last["mass_in"] / 1800.0, 1500.0 * (1 - 1e-9), 1500.0 * (1 + 1e-9)),
            Quantity.near("mass_over_balance", last["mass"] / left, 1.0, relative=1e-10),
            Quantity("growth", last["mass_eroded"] / last["mass_in"], 1.0, 4.0),
            Quantity.near("bed_over_columns", np.nansum(change) * pixel * GROUND / (last["mass_deposited"] - last["mass_eroded"]), 1.0, relative=0.01),
            Quantity("deepest", -np.nanmin(change), 0.25 * DEEPEST, 1.01 * DEEPEST),
            Quantity("deposit_on_fan", risen[:, peak.x > FAN].sum() / risen.sum(), 0.8, 1.0)]


def draw(results):
    from argparse import Namespace

    from pictures.terrain import plot_terrain

    return plot_terrain(results, None, Namespace(step="last", field="bed_change", colours="RdBu_r", limits=[-1.0, 1.0], plain=False, title=None))


if __name__ == "__main__":
    common.main(check, draw)
