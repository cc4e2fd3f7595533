"""Draws a laboratory test (physics: stress_point): q and volume strain against axial strain, the path of p and q, and
the void ratio against the logarithm of p, beside measurements where there are any.

`talus plot` does it by itself for such a run; measurements are a CSV file with columns of the history's names and
signs.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import LogFormatter

from results import ResultsError, von_mises
from tables import TableError, read_rows, read_table

from . import style

COLUMNS = ("strain_yy", "strain_xy", "p", "q", "eps_v", "e")
RUN = {"linewidth": 1.8, "color": "C0", "label": "Talus"}
THEORY = {"linestyle": "--", "linewidth": 1.2, "color": "black", "label": "theory"}
MEASURED = {
    "linestyle": "",
    "marker": "o",
    "markersize": 4.5,
    "markerfacecolor": "white",
    "color": "0.25",
    "label": "measured",
}


def is_laboratory(results):
    try:
        return results.option("mpm_physics", "") == "stress_point"
    except ResultsError:  # nobody kept the options
        return False


def read_measurements(path):
    """The columns of a CSV file that are drawn; other ones may hold anything."""
    try:
        table = read_table(path, COLUMNS)
    except TableError as error:
        raise ResultsError(str(error)) from error
    if not table:
        raise ResultsError(
            f"{path}: has none of the columns {', '.join(COLUMNS)}; there are {', '.join(read_rows(path)[0])}"
        )
    return table


def void_ratio(results, history):
    """The void ratio of a law that knows its specific volume, as history or as parameter; otherwise None."""
    if "specific_volume" in history:
        return history["specific_volume"] - 1.0
    name = f"mpm_material_{results.option('mpm_point_material')}_specific_volume"
    if name not in results.options:
        return None
    eps_v = history["eps_v"]
    ratio = np.exp(eps_v) if results.option("mpm_point_strain") == "log" else 1.0 + eps_v
    return float(results.option(name)) * ratio - 1.0


def read_test(results):
    """What is drawn of the history, with the state at the start, which has no row, before it."""
    history = results.history
    test = {name: history[name] for name in COLUMNS if name in history}
    ratio = void_ratio(results, history)
    if ratio is not None:
        test["e"] = ratio
    stress = np.zeros((1, 6))
    if results.option("mpm_point_stress", ""):
        given = results.numbers("mpm_point_stress")
        stress[0, : len(given)] = given
    start = {"p": stress[0, :3].mean(), "q": von_mises(stress)[0]}
    if "e" in test and "specific_volume" not in history:
        start["e"] = void_ratio(results, {"eps_v": np.zeros(1)})[0]
    elif "e" in test:
        start["e"] = np.nan
    return {name: np.concatenate([[start.get(name, 0.0)], column]) for name, column in test.items()}


def pressure_unit(test):
    """A factor and a unit that keep the stresses' axes readable."""
    largest = max(np.nanmax(np.abs(test[name])) for name in ("p", "q"))
    for factor, unit in ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa")):
        if largest >= factor:
            return 1.0 / factor, unit
    return 1.0, "Pa"


def abscissa_of(results, test):
    """How far the test has been driven: what, its label."""
    if results.option("mpm_point_path") == "simple_shear":
        return lambda columns: 200.0 * columns["strain_xy"], r"$2\,\epsilon_{xy}$ (%)", "strain_xy"
    sign = -1.0 if np.nansum(test["strain_yy"]) <= 0.0 else 1.0
    label = r"axial strain $-\epsilon_{yy}$ (%)" if sign < 0.0 else r"axial strain $\epsilon_{yy}$ (%)"
    return lambda columns: sign * 100.0 * columns["strain_yy"], label, "strain_yy"


def draw_curve(axes, sources, names, x, y):
    """The test's curve, and theory and measurements where these have the columns; x and y take columns."""
    lines = []
    for columns, style in zip(sources, (RUN, THEORY, MEASURED)):
        if columns and all(name in columns for name in names):
            lines += axes.plot(x(columns), y(columns), **style)
    axes.grid(alpha=0.3)
    axes.spines[["top", "right"]].set_visible(False)
    return lines


def plot_laboratory(results, measurements=None, title=None, theory=None):
    """The figure; `measurements` is the name of a CSV file, `theory` columns of a closed form."""
    if results.is_given("mpm_tests"):
        raise ResultsError("several tests: draw one that has a scene of its own")
    test = read_test(results)
    sources = (test, theory, read_measurements(measurements) if measurements else None)
    factor, unit = pressure_unit(test)
    driven, driven_label, strain = abscissa_of(results, test)
    figure, ((top, path), (volume, compression)) = plt.subplots(2, 2, figsize=(7.0, 5.6), layout="constrained")

    lines = draw_curve(top, sources, (strain, "q"), driven, lambda columns: factor * columns["q"])
    top.set(xlabel=driven_label, ylabel=f"$q$ ({unit})")
    draw_curve(volume, sources, (strain, "eps_v"), driven, lambda columns: 100.0 * columns["eps_v"])
    volume.set(xlabel=driven_label, ylabel=r"volume strain $\epsilon_v$ (%), dilation positive")

    def pressure(columns):
        return -factor * columns["p"]

    draw_curve(path, sources, ("p", "q"), pressure, lambda columns: factor * columns["q"])
    path.plot(pressure(test)[0], factor * test["q"][0], "s", color=RUN["color"], markersize=5)
    path.set(xlabel=f"mean pressure $-p$ ({unit})", ylabel=f"$q$ ({unit})")

    name, scale, label = (
        ("e", 1.0, "void ratio $e$") if "e" in test else ("eps_v", 100.0, r"volume strain $\epsilon_v$ (%)")
    )
    draw_curve(compression, sources, ("p", name), pressure, lambda columns: scale * columns[name])
    compression.set(xlabel=f"mean pressure $-p$ ({unit})", ylabel=label)
    if np.nanmin(pressure(test)[1:]) > 0.0:
        compression.set_xscale("log")
        for which in (compression.xaxis.set_major_formatter, compression.xaxis.set_minor_formatter):
            which(LogFormatter(labelOnlyBase=False, minor_thresholds=(2.0, 0.5)))

    heading = title or results.option("mpm_title", "")
    if heading:
        figure.suptitle(heading, fontsize="medium")
    if len(lines) > 1:
        top.legend(frameon=False)
    return figure
