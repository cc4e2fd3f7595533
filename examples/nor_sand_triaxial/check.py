#!/usr/bin/env python3
"""Compares a run of nor_sand_triaxial with the values of an independent program; draws it beside the other sand's run."""
import csv
import re
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402
from results import Results, ResultsError  # noqa: E402

REFERENCE = Path(__file__).resolve().parent / "reference.csv"
STEPS, EXACT = 500, 1e-6  # steps of the reference, and reach with as many
ORDER = {"q": 0.5, "image_pressure": 0.6, "eps_v": 2.0}  # reach with others, over their number: backward Euler
PEAK = {"loose": 654.16024e3, "dense": 963.43995e3}
CONTRACTION = {"loose": 0.669562e-2, "dense": 0.024299e-2}  # the largest
NEWTON = {"loose": 5, "dense": 6}
NORM = re.compile(r"^\s*(\d+) SNES Function norm (\S+)", re.MULTILINE)
SHOWN = (1, 2, 4, 6, 8, 10)  # axial strains whose residuals are drawn, %


def sand(results):
    return results.option("mpm_point_material")


def parameter(results, name):
    return float(results.option(f"mpm_material_{sand(results)}_{name}"))


def reference(name):
    """Columns of the reference for one sand, by the history's names and signs."""
    with open(REFERENCE, encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(line for line in file if not line.startswith("#"))
                if row["material"] == name]
    factors = {"strain_yy": ("axial", -0.01), "q": ("q", 1e3), "eps_v": ("volume", -0.01), "image_pressure": ("image", 1e3)}
    return {to: factor * np.array([float(row[column]) for row in rows]) for to, (column, factor) in factors.items()}


def check(results):
    name, history, steps = sand(results), results.history, int(results.option("mpm_point_steps"))
    exact, known = steps == STEPS, reference(name)
    held = max(np.abs(history[column] - results.numbers("mpm_point_stress")[0]).max() for column in ("stress_xx", "stress_zz"))
    quantities = [common.completed(results),
                  Quantity("newton_max", history["newton"].max(), upper=NEWTON[name] + (0 if exact else 1)),
                  Quantity("held_stress", held, upper=1e-3),
                  Quantity.near("q_peak", history["q"].max(), PEAK[name], relative=EXACT if exact else ORDER["q"] / steps),
                  Quantity.near("contraction", -history["eps_v"].min(), CONTRACTION[name],
                                absolute=1e-8 if exact else 0.02 / steps)]
    for column, order in ORDER.items():
        found = np.interp(-known["strain_yy"], -history["strain_yy"], history[column])
        scale = np.abs(known[column]) if exact else np.abs(known[column]).max()
        error = (np.abs(found - known[column]) / scale).max()
        quantities.append(Quantity("error_" + column, error, upper=EXACT if exact else order / steps))
    return quantities


def residuals(results):
    """Norms of the residuals step by step, where PREFIX_newton.txt has what -snes_monitor says."""
    try:
        text = results.path("_newton.txt").read_text(encoding="utf-8")
    except ResultsError:
        return []
    steps = []
    for number, norm in NORM.findall(text):
        if number == "0":
            steps.append([])
        steps[-1].append(float(norm))
    return steps


def runs(results):
    """This run, and that of the other sand where it has been made: PREFIX with its name."""
    found = {sand(results): results}
    for one, other in (("loose", "dense"), ("dense", "loose")):
        prefix = str(results.prefix)
        if sand(results) == one and prefix.endswith(one) and Path(prefix[:-len(one)] + other + "_history.csv").exists():
            found[other] = Results(prefix[:-len(one)] + other)
    return {name: found[name] for name in ("loose", "dense") if name in found}


def surface(run, image):
    """p and q, kPa, of the yield surface."""
    M, N = parameter(run, "M"), parameter(run, "N")
    p = np.linspace(1e-3, (1 - N) ** (-(1 - N) / N), 300) * image / 1e3
    return p, p * M / N * (1 - (1 - N) * (p * 1e3 / image) ** (N / (1 - N)))


def draw_curves(axes, run, name, color):
    """Stress, volume, and the paths of state."""
    history, known, title = run.history, reference(name), f"{name}, Talus"
    stress, p = run.numbers("mpm_point_stress"), -history["p"] / 1e3
    axial = np.concatenate([[0.0], -100 * history["strain_yy"]])
    axes[0, 0].plot(axial, np.concatenate([[stress[0] - stress[1]], history["q"]]) / 1e3, color=color, label=title)
    axes[0, 1].plot(axial, np.concatenate([[0.0], -100 * history["eps_v"]]), color=color)
    style = {"linestyle": "", "marker": "o", "markersize": 5, "markerfacecolor": "white", "color": color}
    axes[0, 0].plot(-100 * known["strain_yy"], known["q"] / 1e3, **style, label=f"{name}, independent")
    axes[0, 1].plot(-100 * known["strain_yy"], -100 * known["eps_v"], **style)
    axes[0, 2].plot(p, history["q"] / 1e3, color=color)
    for row, width in ((0, 0.7), (-1, 1.2)):
        axes[0, 2].plot(*surface(run, history["image_pressure"][row]), "--", linewidth=width, color=color)
    axes[0, 2].plot(-sum(stress[:3]) / 3e3, (stress[0] - stress[1]) / 1e3, "s", color=color)
    axes[1, 0].plot(p, history["specific_volume"], color=color)
    axes[1, 0].plot(p[0], history["specific_volume"][0], "s", color=color)


def draw_newton(axes, run, name):
    steps, count = residuals(run), int(run.option("mpm_point_steps"))
    axes.set_title(f"Newton's method, {name}", fontsize="medium")
    if not steps:
        axes.text(0.5, 0.5, "run with -snes_monitor", ha="center", transform=axes.transAxes)
    for k, percent in enumerate(SHOWN):
        at = percent * count // 10 - 1
        if at < len(steps):
            axes.semilogy(np.maximum(np.array(steps[at]) / 1e3, 1e-14), "o-", color=f"C{k}", markersize=4, label=f"{percent} %")
    axes.set(xlabel="iteration", ylabel="residual (kPa)", xlim=(-0.2, 6.2), ylim=(1e-14, 1e4))
    axes.legend(frameon=False, fontsize="small", title="axial strain", title_fontsize="small")


def draw(results):
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 3, figsize=(13.0, 7.4), layout="constrained")
    for (name, run), color in zip(runs(results).items(), ("tab:orange", "tab:blue")):
        draw_curves(axes, run, name, color)
        draw_newton(axes[1, 1 if name == "loose" else 2], run, name)
    p = np.geomspace(150.0, 800.0, 50)
    axes[0, 2].plot(p, parameter(results, "M") * p, color="0.3", linewidth=1.0, label="critical state")
    axes[1, 0].plot(p, parameter(results, "v_c0") - parameter(results, "lambda") * np.log(p), color="0.3", linewidth=1.0)
    axes[1, 0].set_xscale("log")
    axes[1, 0].set_xticks([200, 300, 400, 600, 800], ["200", "300", "400", "600", "800"])
    axes[1, 0].minorticks_off()
    axes[0, 0].set(xlabel="axial strain (%)", ylabel="$q$ (kPa)", ylim=(0.0, None))
    axes[0, 1].set(xlabel="axial strain (%)", ylabel="volume lost (%)")
    axes[0, 2].set(xlabel="mean pressure $-p$ (kPa)", ylabel="$q$ (kPa)", xlim=(0.0, None), ylim=(0.0, 1100.0))
    axes[1, 0].set(xlabel="mean pressure $-p$ (kPa)", ylabel="specific volume")
    axes[0, 0].legend(frameon=False)
    axes[0, 2].legend(frameon=False)
    for one in axes.flat:
        one.grid(alpha=0.3)
        one.spines[["top", "right"]].set_visible(False)
    return figure


if __name__ == "__main__":
    common.main(check, draw)
