#!/usr/bin/env python3
"""Compares the resistance of a pipe pulled through clay with its limit in plane strain."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

FACTORS = {"stick": 4.0 * np.sqrt(2.0) + 2.0 * np.pi, "frictionless": 9.20117}  # resistance over s_u D: see README.md
PLATEAU, SETTLED = 0.06, 0.1  # of D: displacements from here on are on the plateau; and where the pipe goes further than 0.2
ERROR = 0.4  # of the cells in a diameter: 5 % at D/8
WAVES = 0.02  # of the plateau's mean: no resistance is further from it; on grids coarser than D/8 twice as much


def strength(results):
    return results.numbers("mpm_material_clay_yield_stress")[0] / np.sqrt(3.0)


def diameter(results):
    return 2.0 * results.numbers("mpm_boundary_pipe_radius")[0]


def cell(results):
    lower, upper = (np.array(results.numbers(f"mpm_grid_{end}")) for end in ("lower", "upper"))
    return np.max((upper - lower) / common.cells(results))


def curve(results):
    """Displacement over D, and the whole pipe's resistance over s_u D."""
    moved = results.column("time") * results.numbers("mpm_boundary_pipe_motion")[0]
    return moved / diameter(results), 2.0 * results.column("reaction_pipe_x") / (strength(results) * diameter(results))


def theory(results):
    return FACTORS[results.option("mpm_boundary_pipe_friction", "frictionless")]


def check(results):
    moved, resistance = curve(results)
    plateau = resistance[moved >= (SETTLED if moved[-1] > 0.2 else PLATEAU) - 1e-9]
    mean = np.mean(plateau) if plateau.size else np.nan
    size = cell(results) / diameter(results)
    others = sum(results.column(f"reaction_{name}_x")[-1] for name in ("rim", "left", "right"))
    force = results.column("reaction_pipe_x")[-1]
    steps = results.column("step").size
    return [common.completed(results),
            Quantity.near("resistance_over_su_D", mean, theory(results), relative=ERROR * size),
            Quantity("waves", np.max(np.abs(plateau / mean - 1.0), initial=0.0), None, WAVES * (1.0 if size <= 1.0 / 7.9 else 2.0)),
            Quantity("balance", abs(force + others) / abs(force), None, 1e-6),
            Quantity("newton_a_step", np.sum(results.column("newton")) / steps, None, 6.0),
            Quantity("cuts", np.sum(results.column("cuts")), None, 0.0)]


def draw(results):
    """The plastic strain round the pipe, and resistance against displacement."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_plane

    figure = plt.figure(figsize=(12.0, 4.4), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1.4, 1.0))
    state = results.state("last")
    flow = state["equivalent_plastic_strain"]
    axes, body = draw_plane(left, results, state, flow, ("magma_r", 0.0, np.percentile(flow, 98.0)), False)
    left.colorbar(body, ax=axes, shrink=0.7, label="equivalent plastic strain")
    axes.set(xlim=(-1.6, 1.8), ylim=(0.0, 1.7))

    moved, resistance = curve(results)
    axes = right.add_subplot()
    axes.axhline(theory(results), color="0.3", label="theory")
    axes.plot(moved, resistance, ".-", color="tab:blue", label="Talus")
    axes.set(xlabel="displacement over D", ylabel="resistance over $s_u D$", ylim=(0.0, None))
    axes.grid(alpha=0.3)
    axes.legend(loc="lower right")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
