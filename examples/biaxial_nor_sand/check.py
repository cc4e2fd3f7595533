#!/usr/bin/env python3
"""Biaxial compression of sand: a homogeneous specimen against the laboratory, or a shear band's load, width and inclination."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402
from laboratory import path  # noqa: E402
from results import Results  # noqa: E402

COMPONENTS = ("xx", "yy", "zz", "xy")
NEWTON = 8  # iterations a step, at most, where the specimen stays homogeneous
NEWTON_MEAN = 6  # on average, with a band
SAME = 1e-8  # of the axial stress
SLIT = 0.5  # the middle part of the band whose width is measured


def is_band(results):
    return "spot" in results.option("mpm_bodies").split(",")


def width(results):
    """Of the specimen at the start."""
    position = results.initial["position0"]
    return np.ptp(position[:, 0]) + np.diff(np.unique(position[:, 0].round(9))).min()


def against_laboratory(results):
    """Errors of stress, over the axial one, and of the history, relative, and how far stresses differ from point to point."""
    curve = Results(results.prefix + "_laboratory").history
    spread, stress, history = 0.0, 0.0, 0.0
    for step in results.steps[1:]:
        state, row = results.state(step), np.argmin(np.abs(curve["time"] - results.column("time")[step - 1]))
        axial = abs(curve["stress_yy"][row])
        expected = np.array([curve["stress_" + name][row] for name in COMPONENTS])
        spread = max(spread, np.ptp(state["stress"][:, :4], axis=0).max() / axial)
        stress = max(stress, np.abs(state["stress"][:, :4] - expected).max() / axial)
        for name in ("image_pressure", "specific_volume"):
            history = max(history, np.abs(state[name] / curve[name][row] - 1.0).max())
    return spread, stress, history


def force_error(results):
    """Of the platen's force over what the stress in the last state makes of it."""
    state = results.state("last")
    expected = state["stress"][:, 1].mean() * width(results) * state["F"][:, 0].mean()
    return abs(results.column("reaction_platen_y")[-1] / expected - 1.0)


def shear(state):
    """sqrt(2/3) |dev ln V| of each point."""
    F = state["F"].reshape(-1, 3, 3)
    strain = 0.5 * np.log(np.linalg.eigvalsh(F @ F.transpose(0, 2, 1)))
    return np.sqrt(2.0 / 3.0) * np.linalg.norm(strain - strain.mean(axis=1, keepdims=True), axis=1)


def band(results):
    """Width (m) of the band, the strain across it over its largest, and its inclination (degrees)."""
    state = results.state("last")
    x, strain = state["position"], shear(state)
    inside = strain > 0.5 * np.quantile(strain, 0.999)
    middle = x[inside].mean(axis=0)
    along = np.linalg.svd(x[inside] - middle, full_matrices=False)[2][0]
    reach = SLIT * np.abs((x[inside] - middle) @ along).max()
    near = np.abs((x - middle) @ along) < reach
    across = (x[near] - middle) @ np.array([-along[1], along[0]])
    h = 0.25 * results.numbers("mpm_grid_upper")[1] / common.cells(results)[1]
    count, edges = np.histogram(across, np.arange(-60.5, 61.0) * h)
    profile = np.histogram(across, edges, weights=strain[near])[0] / np.maximum(count, 1)
    profile = np.maximum(profile - np.median(strain[near]), 0.0)
    return profile.sum() * h / profile.max(), np.degrees(np.arctan2(*np.abs(along[::-1])))


def load(results):
    """The platen's way over the height, and its force over the first width, Pa."""
    height = results.numbers("mpm_boundary_platen_point")[1]
    way = -results.numbers("mpm_boundary_platen_motion")[1] * results.column("time")
    return way / height, -results.column("reaction_platen_y") / width(results)


def check(results):
    quantities, newton = [common.completed(results)], results.column("newton")
    if not is_band(results):
        quantities.append(Quantity("newton_max", newton.max(), upper=NEWTON))
        strain = 1.0 - path(results)[1]
        spread, stress, history = against_laboratory(results)
        return quantities + [
            Quantity.near("axial_strain", strain[-1], 0.1 * results.column("time")[-1], relative=1e-3),
            Quantity("stress_spread", spread, upper=SAME), Quantity("stress_error", stress, upper=SAME),
            Quantity("history_error", history, upper=SAME), Quantity("force_error", force_error(results), upper=1e-6)]
    strain, nominal = load(results)
    thickness, inclination = band(results)
    h = results.numbers("mpm_grid_upper")[1] / common.cells(results)[1]
    return quantities + [
        Quantity("newton_a_step", newton.mean(), upper=NEWTON_MEAN), Quantity("cuts", results.column("cuts").sum(), upper=0),
        Quantity("peak", nominal.max(), 2.2e6, 2.6e6), Quantity("peak_strain", strain[nominal.argmax()], 0.03, 0.045),
        Quantity("residual_over_peak", nominal[-1] / nominal.max(), 0.3, 0.5),
        Quantity("band_width", thickness), Quantity("band_width_in_cells", thickness / h, 1.5, 4.0),
        Quantity("band_inclination", inclination, 45.0, 65.0)]


def others(results):
    """This run and those of the README's names that lie beside it."""
    found = {}
    for name in ("loose", "dense", "band", "band_coarse"):
        prefix = Path(results.prefix).parent / f"biaxial_{name}"
        if Path(f"{prefix}_summary.json").exists():
            found[name] = Results(prefix)
    return found or {"band" if is_band(results) else "loose": results}


def draw_homogeneous(axes, runs):
    for name, color in (("loose", "tab:orange"), ("dense", "tab:blue")):
        if name not in runs:
            continue
        curve = Results(runs[name].prefix + "_laboratory").history
        axes[0].plot(-100.0 * curve["strain_yy"], -curve["stress_yy"] / 1e6, color=color, linewidth=1.0, label=f"{name}, laboratory")
        axes[1].plot(-100.0 * curve["strain_yy"], 100.0 * curve["eps_v"], color=color, linewidth=1.0)
        for step in runs[name].steps[1:]:
            state = runs[name].state(step)
            strain = 100.0 * (1.0 - state["F"][:, 4].mean())
            axes[0].plot(strain, -state["stress"][:, 1].mean() / 1e6, "o", color=color, markerfacecolor="white")
            axes[1].plot(strain, 100.0 * (np.linalg.det(state["F"].reshape(-1, 3, 3)).mean() - 1.0), "o", color=color,
                         markerfacecolor="white")
    axes[0].set(xlabel="axial strain (%)", ylabel="axial stress (MPa)", title="smooth platens, homogeneous", ylim=(0.0, None))
    axes[1].set(xlabel="axial strain (%)", ylabel="volume strain (%)")
    axes[0].legend(frameon=False)


def draw_band(figure, axes, runs):
    bands = {name: runs[name] for name in ("band_coarse", "band") if name in runs}
    for k, (name, run) in enumerate(bands.items()):
        strain, nominal = load(run)
        h = 1e3 * run.numbers("mpm_grid_upper")[1] / common.cells(run)[1]
        axes[0].plot(100.0 * strain, nominal / 1e6, label=f"cells of {h:.0f} mm")
        state = run.state("last")
        dots = axes[k + 1].scatter(*(1e3 * state["position"]).T, c=shear(state), s=5000.0 * h**2 / 72.0**2, marker="s",
                                   linewidths=0.0, vmin=0.0, vmax=1.5)
        axes[k + 1].set(title=f"cells of {h:.0f} mm", aspect="equal", xlabel="x (mm)")
        if k == len(bands) - 1:
            figure.colorbar(dots, ax=axes[k + 1], label="shear strain")
    axes[0].set(xlabel="axial strain (%)", ylabel="force / first width (MPa)", title="dense, with a loose spot", ylim=(0.0, None))
    if bands:
        axes[0].legend(frameon=False)


def draw(results):
    import matplotlib.pyplot as plt

    runs = others(results)
    figure, axes = plt.subplots(1, 5, figsize=(14.0, 3.8), layout="constrained")
    draw_homogeneous(axes[:2], runs)
    draw_band(figure, axes[2:], runs)
    for one in axes[:3]:
        one.grid(alpha=0.3)
        one.spines[["top", "right"]].set_visible(False)
    return figure


if __name__ == "__main__":
    common.main(check, draw)
