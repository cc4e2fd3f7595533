#!/usr/bin/env python3
"""Compares a run of rubber_uniaxial with its closed form and with Treloar's measurements."""
import csv
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402

EXACT = 1e-10     # of the largest value
MEASURED = 0.07   # root mean square of the measured force's error, over the largest force
KGF_CM2 = 98066.5  # Pa


def terms(results):
    """alpha and mu of each term."""
    rows = [row.split(":") for row in results.option("mpm_material_rubber_terms").split(",")]
    return [(float(alpha), float(mu)) for alpha, mu in rows]


def kirchhoff(results, axial, lateral):
    """Principal Kirchhoff stresses along y and across, from the logarithmic stretches there."""
    bulk, volume = float(results.option("mpm_material_rubber_bulk_modulus")), axial + 2.0 * lateral
    powers = [(mu, np.exp(alpha * (axial - volume / 3.0)), np.exp(alpha * (lateral - volume / 3.0)))
              for alpha, mu in terms(results)]
    pressure = 0.5 * bulk * np.expm1(2.0 * volume)
    along = sum(mu * (y - x) for mu, y, x in powers) * 2.0 / 3.0 + pressure
    across = -sum(mu * (y - x) for mu, y, x in powers) / 3.0 + pressure
    return along, across


def theory(results, axial):
    """Cauchy stress along y and volume strain where the lateral stress is zero, by bisection of the lateral stretch."""
    lower, upper = -0.5 * axial - 0.5, -0.5 * axial + 0.5
    for _ in range(80):
        middle = 0.5 * (lower + upper)
        above = kirchhoff(results, axial, middle)[1] > 0.0
        lower, upper = np.where(above, lower, middle), np.where(above, middle, upper)
    volume = axial + 2.0 * middle
    return kirchhoff(results, axial, middle)[0] / np.exp(volume), volume


def force(results, axial):
    """Force over initial area of the incompressible solid."""
    stretch = np.exp(axial)
    return sum(mu * (stretch ** (alpha - 1.0) - stretch ** (-0.5 * alpha - 1.0)) for alpha, mu in terms(results))


def measurements():
    with open(Path(__file__).resolve().parent / "treloar.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return np.array([[float(row["stretch"]), float(row["force"]) * KGF_CM2] for row in rows]).T


def run_force(results):
    """The run's own force over initial area: Cauchy stress times J over the stretch."""
    axial = results.column("strain_yy")
    return results.column("stress_yy") * np.exp(results.column("eps_v") - axial)


def check(results):
    axial = results.column("strain_yy")
    stress, volume = theory(results, axial)
    stretch, measured = measurements()
    error = np.interp(stretch, np.exp(axial), run_force(results)) - measured
    lateral = max(np.abs(results.column(name)).max() for name in ("stress_xx", "stress_zz"))
    return [common.completed(results),
            common.Quantity("error_stress", np.abs(results.column("stress_yy") - stress).max() / stress[-1], upper=EXACT),
            common.Quantity("error_eps_v", np.abs(results.column("eps_v") - volume).max() / volume[-1], upper=1e-8),
            common.Quantity("lateral_stress", lateral / stress[-1], upper=EXACT),
            common.Quantity("error_incompressible", np.abs(run_force(results) / force(results, axial) - 1.0).max(),
                            upper=0.02),
            common.Quantity("error_measured", np.sqrt(np.mean(error ** 2)) / measured[-1], upper=MEASURED),
            common.Quantity("newton_max", results.column("newton").max(), upper=6)]


def draw(results):
    axial = results.column("strain_yy")
    stretch, measured = measurements()
    figure, axes = plt.subplots(figsize=(6.4, 4.4), layout="constrained")
    axes.plot(np.exp(axial), 1e-6 * run_force(results), linewidth=1.8, color="C0", label="Talus")
    axes.plot(np.exp(axial), 1e-6 * force(results, axial), "--", linewidth=1.2, color="black",
              label="closed form, incompressible")
    axes.plot(stretch, 1e-6 * measured, "o", markersize=4.5, markerfacecolor="white", color="0.25",
              label="Treloar (1944)")
    axes.set(xlabel="stretch", ylabel="force over initial area (MPa)")
    axes.grid(alpha=0.3)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
