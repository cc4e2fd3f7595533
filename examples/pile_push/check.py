#!/usr/bin/env python3
"""Sets the resistance of a pile pushed into clay beside what is known of deep tips, and looks for balance and steadiness."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

STEADY = 1.5  # widths of travel from which on the resistance is steady
FACTORS = (7.5, 10.5)  # of a tip as wide as D + h: see README.md
NOISE = 0.05  # standard deviation of the steady resistance over its mean: a wave with each cell that goes by
DRIFT = 0.1  # of the steady resistance, from its first half to its second
BALANCE = 1e-6
INTRUDED = 0.005  # share of the clay inside the pile's outline


def strength(results):
    return results.numbers("mpm_material_clay_yield_stress")[0] / np.sqrt(3.0)


def width(results):
    return 2.0 * results.numbers("mpm_body_head_upper")[0]


def cell(results):
    lower, upper = (results.numbers(f"mpm_grid_{end}")[0] for end in ("lower", "upper"))
    return (upper - lower) / common.cells(results)[0]


def travel(results, time):
    return -results.numbers("mpm_motion_head_value")[2] * np.asarray(time)


def start(results):
    """Depth of the tip at the start, m."""
    return -results.numbers("mpm_bc_tip_lower")[2]


def force(results):
    """On the whole pile, N; positive down."""
    return -4.0 * (results.column("reaction_tip_z") + results.column("reaction_inside_z") + results.column("reaction_head_z"))


def curve(results):
    """Travel over the width, and the resistance over s_u D^2."""
    return (travel(results, results.column("time")) / width(results),
            force(results) / (strength(results) * width(results)**2))


def intruded(results):
    """Share of the clay's volume that is inside the pile's outline at the end, by more than a hundredth of the width."""
    state, skin = results.state("last"), 0.01 * width(results)
    place, clay = state["position"], state["material"] == 0
    tip = -start(results) - travel(results, results.column("time")[-1])
    within = clay & (place[:, :2].max(axis=1) < 0.5 * width(results) - skin) & (place[:, 2] > tip + skin)
    return state["volume"][within].sum() / state["volume"][clay].sum()


def check(results):
    way, resistance = curve(results)
    steady = way >= STEADY
    balance = np.abs(force(results) / 4.0 - results.column("reaction_base_z"))
    quantities = [common.completed(results),
                  Quantity("balance", np.max(balance) / np.max(force(results) / 4.0), None, BALANCE),
                  Quantity("intruded", intruded(results), None, INTRUDED),
                  Quantity("newton_a_step", results.column("newton").mean(), None, 6.0),
                  Quantity("cuts", results.column("cuts").sum(), None, 0.0)]
    if np.count_nonzero(steady) < 10:
        return quantities + [Quantity("largest_over_su_D2", resistance.max())]
    part = resistance[steady]
    mean, half = part.mean(), part.size // 2
    quantities += [Quantity("resistance_over_su_D2", mean),
                   Quantity("bearing_factor", mean / (1.0 + cell(results) / width(results))**2, *FACTORS),
                   Quantity("noise", part.std() / mean, None, NOISE),
                   Quantity("drift", abs(part[half:].mean() - part[:half].mean()) / mean, None, DRIFT)]
    return quantities


def draw(results):
    """Plastic strain in the plane of symmetry at the end, and the resistance."""
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(11.0, 5.6), layout="constrained", width_ratios=(1.0, 1.3))
    state = results.state("last")
    place, half = state["position"], 0.5 * width(results)
    near = (place[:, 1] < 0.5 * cell(results)) & (state["material"] == 0)
    flow = state["equivalent_plastic_strain"][near]
    order = np.argsort(flow)
    for sign in (-1.0, 1.0):
        points = left.scatter(sign * place[near, 0][order], place[near, 2][order], c=flow[order], s=9.0, cmap="magma_r",
                              vmin=0.0, vmax=np.percentile(flow, 95.0))
    tip = -start(results) - travel(results, results.column("time")[-1])
    left.add_patch(plt.Rectangle((-half, tip), 2.0 * half, 1.0 - tip, color="0.6"))
    figure.colorbar(points, ax=left, label="equivalent plastic strain")
    left.set(aspect="equal", xlabel="x (m)", ylabel="z (m)", ylim=(None, 1.0))
    way, resistance = curve(results)
    h = cell(results) / width(results)
    right.plot(np.r_[0.0, way], np.r_[0.0, resistance], ".-", label="resistance over $s_u D^2$")
    right.plot(way, resistance / (1.0 + h)**2, "--", label="over $s_u (D + h)^2$")
    right.axhspan(7.6, 10.3, color="0.85", label="deep tips, published")
    right.set(xlabel="travel over D", ylabel="bearing factor", xlim=(0.0, None), ylim=(0.0, None),
              title=f"h = D/{1.0 / h:.3g}")
    right.grid(alpha=0.3)
    right.legend(loc="lower right")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
