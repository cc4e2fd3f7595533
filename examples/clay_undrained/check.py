#!/usr/bin/env python3
"""Compares a run of clay_undrained with its closed form."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from pictures.laboratory import plot_laboratory  # noqa: E402

EXACT = 1e-10  # of p in terms of q: at constant volume the return map makes no error
FIRST_ORDER = 3e-3  # of q in terms of the strain, in 200 steps


def constants(results):
    """kappa, lambda, M, G and the pressure at the start."""
    names = ("kappa", "lambda", "M", "G")
    return [float(results.option("mpm_material_clay_" + name)) for name in names] + [-results.numbers("mpm_point_stress")[0]]


def pressure(results, ratio):
    """p on the path, positive in compression, at q/p."""
    kappa, slope, M, _, start = constants(results)
    return start * (M**2 / (M**2 + ratio**2)) ** (1 - kappa / slope)


def theory(results, count=2000):
    """The path up to the end of the run, by q/p."""
    kappa, slope, M, G, _ = constants(results)
    ratio = M * -np.expm1(-np.linspace(0.0, 30.0, count))  # dense towards M
    q = ratio * pressure(results, ratio)
    eps_q = q / (3 * G) + kappa * (1 - kappa / slope) / M * (np.log((M + ratio) / (M - ratio)) - 2 * np.arctan(ratio / M))
    keep = eps_q <= abs(float(results.option("mpm_point_end")))
    return {"strain_yy": -eps_q[keep], "q": q[keep], "p": -pressure(results, ratio)[keep], "eps_v": 0.0 * q[keep]}


def q_at(results, eps_q):
    exact = theory(results, 40000)
    return np.interp(eps_q, -exact["strain_yy"], exact["q"])


def check(results):
    M = constants(results)[2]
    p, q, eps_q, size = (results.column(name) for name in ("p", "q", "eps_q", "preconsolidation"))
    expected = pressure(results, q / -p)
    at_two = np.argmin(np.abs(eps_q - 0.02))
    return [common.completed(results),
            common.Quantity("error_p", np.abs(-p / expected - 1).max(), upper=EXACT),
            common.Quantity("error_yield", np.abs(q**2 / M**2 + p * (p + size)).max() / size.max() ** 2, upper=EXACT),
            common.Quantity("error_eps_v", np.abs(results.column("eps_v")).max(), upper=1e-14),
            common.Quantity.near("q_at_2_percent", q[at_two], q_at(results, eps_q[at_two]), relative=FIRST_ORDER),
            common.Quantity.near("q_end", q[-1], q_at(results, eps_q[-1]), relative=FIRST_ORDER)]


def draw(results):
    figure = plot_laboratory(results, theory=theory(results))
    figure.axes[2].set_ylim(-1, 1)  # neither changes but by rounding
    figure.axes[3].set_ylim(1, 1.2)
    return figure


if __name__ == "__main__":
    common.main(check, draw)
