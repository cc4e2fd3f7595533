#!/usr/bin/env python3
"""Compares a run of triaxial with its closed form."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from pictures.laboratory import plot_laboratory  # noqa: E402

EXACT = 1e-10  # of the largest value: on this path the return map makes no error


def parameter(results, name):
    return float(results.option("mpm_material_sand_" + name))


def cone(degrees):
    """Slope and cohesion factor of the cone that meets Mohr-Coulomb in triaxial compression."""
    angle = np.radians(degrees)
    scale = 6.0 / (np.sqrt(3.0) * (3.0 - np.sin(angle)))
    return scale * np.sin(angle), scale * np.cos(angle)


def strength(results):
    """q at failure under the confining pressure."""
    slope, factor = cone(parameter(results, "friction"))
    confining = -results.numbers("mpm_point_stress")[0]
    return (factor * parameter(results, "cohesion") + slope * confining) / (1.0 / np.sqrt(3.0) - slope / 3.0)


def theory(results, strain):
    """Columns of the history at axial strains (of negative sign, that of compression)."""
    modulus, nu = parameter(results, "E"), parameter(results, "nu")
    dilation = cone(parameter(results, "dilation"))[0]
    q = np.minimum(modulus * -strain, strength(results))
    plastic = (-strain - q / modulus) / (1.0 / np.sqrt(3.0) - dilation / 3.0)
    return {"strain_yy": strain, "q": q, "p": results.numbers("mpm_point_stress")[0] - q / 3.0,
            "eps_v": dilation * plastic - (1.0 - 2.0 * nu) * q / modulus}


def check(results):
    exact = theory(results, results.column("strain_yy"))
    confining = results.numbers("mpm_point_stress")[0]
    held = max(np.abs(results.column(name) - confining).max() for name in ("stress_xx", "stress_zz"))
    quantities = [common.completed(results),
                  common.Quantity.near("q_end", results.column("q")[-1], strength(results), relative=EXACT),
                  common.Quantity("held_stress", held / abs(confining), upper=EXACT),
                  common.Quantity("newton_max", results.column("newton").max(), upper=4)]
    for name in ("q", "p", "eps_v"):
        error = np.abs(results.column(name) - exact[name]).max() / np.abs(exact[name]).max()
        quantities.append(common.Quantity("error_" + name, error, upper=EXACT))
    return quantities


def draw(results):
    strain = np.linspace(0.0, results.column("strain_yy")[-1], 400)
    return plot_laboratory(results, theory=theory(results, strain))


if __name__ == "__main__":
    common.main(check, draw)
