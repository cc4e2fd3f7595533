#!/usr/bin/env python3
"""Compares a run of mms with the manufactured solution."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, cells, completed  # noqa: E402

AMPLITUDE = np.array([0.10, -0.08, 0.06])  # as in mms.c
# Upper bounds of the relative errors of displacement and stress with gimp and two points a cell and axis: a fifth above what was
# measured, by dimension and number of cells per axis.
BOUNDS = {(2, 8): (3.9e-3, 3.4e-2), (2, 16): (6.0e-4, 1.1e-2), (2, 32): (1.2e-4, 3.5e-3), (2, 64): (4.0e-5, 1.5e-3),
          (3, 4): (2.2e-2, 1.5e-1), (3, 8): (4.0e-3, 3.6e-2), (3, 16): (6.0e-4, 1.1e-2)}


def exact(results, place):
    """Displacement and the stresses along the axes at places of the initial state."""
    young, nu = (float(results.option(f"mpm_material_rubber_{name}")) for name in ("E", "nu"))
    lame, mu = young * nu / ((1 + nu) * (1 - 2 * nu)), young / (2 * (1 + nu))
    amplitude = AMPLITUDE[:place.shape[1]]
    stretch = 1 + amplitude * np.pi * np.cos(np.pi * place)
    volume = stretch.prod(axis=1)[:, None]
    return amplitude * np.sin(np.pi * place), (mu * (stretch**2 - 1) + lame * np.log(volume)) / volume


def errors(results):
    """Relative errors of displacement and stress, root mean squares weighted by initial volume."""
    first, last = results.state("first"), results.state("last")
    displacement, stress = exact(results, first["position0"])
    weight = first["volume"][:, None]

    def relative(value, reference):
        return np.sqrt(np.sum(weight * (value - reference) ** 2) / np.sum(weight * reference**2))

    dim = first["position0"].shape[1]
    return relative(last["displacement"], displacement), relative(last["stress"][:, :dim], stress)


def check(results):
    dim = len(cells(results))
    displacement, stress = errors(results)
    bounds = BOUNDS.get((dim, cells(results)[0])) if results.option("mpm_shape", "gimp") == "gimp" else None
    return [completed(results), Quantity("displacement_error", displacement, upper=bounds[0] if bounds else 0.5),
            Quantity("stress_error", stress, upper=bounds[1] if bounds else 0.5)]


def draw(results):
    import matplotlib.pyplot as plt

    first, last = results.state("first"), results.state("last")
    _, stress = exact(results, first["position0"])
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.2), constrained_layout=True)
    place = last["position"]
    for axis, value, title in ((axes[0], last["stress"][:, 0], "stress xx, computed (kPa)"),
                               (axes[1], last["stress"][:, 0] - stress[:, 0], "computed - exact (kPa)")):
        dots = axis.scatter(place[:, 0], place[:, 1], c=value / 1e3, s=2e4 / len(place), marker="s", cmap="coolwarm")
        figure.colorbar(dots, ax=axis)
        axis.set(title=title, xlabel="x (m)", ylabel="y (m)", aspect="equal")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
