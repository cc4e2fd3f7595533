#!/usr/bin/env python3
"""Compares the pore pressures under an undrained strip load with Fourier's series, and measures how they alternate."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

PLACES = ((0.0, 0.5), (0.0, 1.0), (0.0, 2.0), (1.0, 1.0), (2.0, 1.0))  # x and depth over b
REACH = {"fine": 0.01, "coarse": 0.03}  # of q; cells up to b/8, and larger ones
ALTERNATING = 0.02  # of q
EDGE = 0.5  # from the load's edge, over b, where the pressure is not smooth


def size(results):
    """Half width b of the load, width L, depth H, load q, cell h."""
    lower, upper = results.numbers("mpm_body_under_lower"), results.numbers("mpm_body_under_upper")
    ends = results.numbers("mpm_grid_upper")[0] - results.numbers("mpm_grid_lower")[0]
    return (upper[0] - lower[0], results.numbers("mpm_body_beside_upper")[0] - lower[0], upper[1] - lower[1],
            -results.numbers("mpm_surface_strip_normal")[0], ends / common.cells(results)[0])


def series(results, x, depth, terms=4000):
    """p/q of the undrained layer, with factors exp(-k z) taken out of the hyperbolic functions."""
    b, width, height = size(results)[:3]
    k = np.arange(1, terms) * np.pi / width
    small = np.exp(-2.0 * k * height)
    shape = np.exp(-k * depth) * (1.0 - small) * (1.0 + np.exp(-2.0 * k * (height - depth)))
    shape /= 1.0 - small**2 + 4.0 * k * height * small
    return b / width + np.sum(2.0 * np.sin(k * b) / (k * width) * shape * np.cos(k * x))


def points(results):
    """Places from the upper corner on the axis, x and depth, and pressures over the load."""
    state = results.state("last")
    place = state["position"].copy()
    place[:, 1] = results.numbers("mpm_body_under_upper")[1] - place[:, 1]
    return place, state["pressure"] / size(results)[3]


def pressure_at(results, x, depth):
    """By a plane through the points nearby; on the axis the slope across it is none."""
    h, (place, pressure) = size(results)[4], points(results)
    near = np.all(np.abs(place - (x, depth)) < 1.01 * h, axis=1)
    across = place[near, 0] - x
    terms = [np.ones(near.sum()), across**2 if x == 0.0 else across, place[near, 1] - depth]
    return np.linalg.lstsq(np.stack(terms, axis=1), pressure[near], rcond=None)[0][0]


def nodal(results):
    """Pressures at the nodes, the means over their cells of planes bent through the points: rows by x, then depth."""
    h, (place, pressure) = size(results)[4], points(results)
    cell = np.floor(place / h).astype(int)
    count = cell.max(axis=0) + 1
    total, weight = np.zeros(count + 1), np.zeros(count + 1)
    key = cell[:, 0] * count[1] + cell[:, 1]
    for k in np.unique(key):
        x, y = ((place[key == k] / h - cell[key == k]) - 0.5).T
        terms = np.stack([np.ones(x.size), x, y, x * y], axis=1)
        fit = np.linalg.lstsq(terms, pressure[key == k], rcond=None)[0]
        for a in (0, 1):
            for b in (0, 1):
                node = k // count[1] + a, k % count[1] + b
                total[node] += fit @ (1.0, a - 0.5, b - 0.5, (a - 0.5) * (b - 0.5))
                weight[node] += 1.0
    return total / weight


def alternating(results):
    """What changes its sign from node to node along x or along the depth."""
    b, h, values = size(results)[0], size(results)[4], nodal(results)
    largest = 0.0
    for axis in (0, 1):
        change = np.abs(np.diff(values, 2, axis=axis)) / 4.0
        x, depth = ((np.arange(n) + (1 if a == axis else 0)) * h for a, n in enumerate(change.shape))
        largest = max(largest, change[np.hypot(x[:, None] - b, depth[None, :]) > EDGE * b].max())
    return largest


def check(results):
    b, h = size(results)[0], size(results)[4]
    reach = REACH["fine" if h <= b / 8.0 + 1e-9 else "coarse"]
    quantities = [common.completed(results)]
    for x, depth in PLACES:
        quantities.append(Quantity.near(f"p_at_{x:g}_{depth:g}", pressure_at(results, x * b, depth * b),
                                        series(results, x * b, depth * b), absolute=reach))
    if float(results.option("mpm_stabilization_ppp", "1")) > 0.0:
        bounds = {"upper": ALTERNATING}
    else:  # the ghost penalty on the pressure of edge cells holds some of it
        bounds = {"lower": (10.0 if results.option("mpm_stabilization_ghost") == "off" else 1.5) * ALTERNATING}
    return quantities + [Quantity("alternating", alternating(results), **bounds)]


def draw(results):
    """Pressures in the ground, and along three verticals beside the series."""
    import matplotlib.pyplot as plt

    (b, width, height, _, h), (place, pressure) = size(results), points(results)
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.0, 4.6), layout="constrained")
    dots = left.tripcolor(place[:, 0] / b, -place[:, 1] / b, pressure, vmin=0.0, vmax=1.0, shading="gouraud")
    left.plot([0.0, 1.0], [0.0, 0.0], color="tab:red", linewidth=5.0)
    left.set(xlabel="x/b", ylabel="y/b", aspect="equal", xlim=(0.0, width / b), ylim=(-height / b, 0.1))
    left.set_title("p/q at the points", fontsize="medium")
    figure.colorbar(dots, ax=left, shrink=0.8)
    depths = np.linspace(0.0, height, 200)
    for x, color in ((0.0, "tab:blue"), (1.0, "tab:orange"), (2.0, "tab:green")):
        right.plot([series(results, x * b, z) for z in depths], depths / b, color=color)
        near = np.abs(place[:, 0] - x * b) < 0.3 * h
        right.plot(pressure[near], place[near, 1] / b, ".", color=color, label=f"x = {x:g} b")
    right.set(xlabel="p/q", ylabel="depth over b", ylim=(height / b, 0.0), xlim=(0.0, None))
    right.grid(alpha=0.3)
    right.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
