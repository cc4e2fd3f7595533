"""What the benchmarks' pictures share."""
from math import isfinite
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")  # told apart by all eyes
MARKERS = ("o", "s", "^", "D", "v", "P")
LINES = ("-", "--", ":", "-.")


def panels(count, width=5.2, height=4.4):
    """A figure with panels side by side."""
    figure, axes = plt.subplots(1, count, figsize=(width * count, height), layout="constrained", squeeze=False)
    return figure, list(axes[0])


def panels_with_legend(count, handles, width=5.2, height=4.4, legend=2.2):
    """Panels side by side and, beside them, a legend for all."""
    figure, axes = plt.subplots(1, count + 1, figsize=(width * count + legend, height), layout="constrained",
                                width_ratios=[width] * count + [legend])
    axes[-1].axis("off")
    axes[-1].legend(handles=handles, loc="center left", borderaxespad=0.0, frameon=False)
    return figure, list(axes[:-1])


def label(axes, title, x, y, log="xy"):
    """Axis labels, logarithmic axes where there is anything to draw, a grid, a panel's title."""
    if "x" in log and isfinite(axes.dataLim.minposx):
        axes.set_xscale("log")
    if "y" in log and isfinite(axes.dataLim.minposy):
        axes.set_yscale("log")
    axes.set(xlabel=x, ylabel=y)
    axes.set_title(title, fontsize="medium")
    axes.grid(alpha=0.3, which="both", linewidth=0.5)


def ticks(axes, values):
    """The values themselves as ticks of a logarithmic x axis."""
    axes.set_xticks(sorted(values), [f"{value:.3g}" for value in sorted(values)])
    axes.minorticks_off()


def key(name, colour="0.3", marker="", line="-"):
    """An entry of a legend that explains one trait of the curves."""
    return Line2D([], [], color=colour, marker=marker, linestyle=line, label=name)


def save(figure, folder, name):
    path = Path(folder) / f"{name}.png"
    figure.savefig(path, dpi=150)
    plt.close(figure)
    print(path)
