"""Forces along a row of cuts, and stress along a line, of a run of Talus."""
import matplotlib.pyplot as plt
import numpy as np

from results import find_step

# Panels: label, unit, columns with their names in the legend; the first set whose columns are there.
SECTION = ((("normal force", "N", {"n": "N"}), ("shear force", "N", {"v": "V"}), ("bending moment", "N m", {"m": "M"})),
           (("normal force", "N", {"n": "N"}), ("shear forces", "N", {"v1": "$V_1$", "v2": "$V_2$"}),
            ("moments", "N m", {"m1": "$M_1$", "m2": "$M_2$", "t": "T"})))
PROFILE = ((("normal stress", "Pa", {"n": "$\\sigma_n$"}), ("shear stress", "Pa", {"t": "$\\tau$"})),
           (("normal stress", "Pa", {"n": "$\\sigma_n$"}), ("shear stress", "Pa", {"t1": "$\\tau_1$", "t2": "$\\tau_2$"})))


def scale(columns, unit):
    """A factor and a unit with a metric prefix that keep the axis readable; per metre of thickness in plane strain."""
    largest = max((np.max(np.abs(column[np.isfinite(column)]), initial=0.0) for column in columns), default=0.0)
    for factor, prefix in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if largest >= factor:
            return 1.0 / factor, prefix + unit
    return 1.0, unit


def rows_of(results, kind, name, step):
    """The columns of a section's or profile's file at one step, and the step."""
    table = results.table(kind, name)
    number = find_step(step, np.unique(table["step"]), f"{kind} {name}")
    chosen = table["step"] == number
    return {key: values[chosen] for key, values in table.items()}, number


def plot_line(results, kind, name, step, title):
    """A panel each for the normal, the transverse and the turning part, along the row or the line."""
    rows, number = rows_of(results, kind, name, step)
    panels = next(one for one in (SECTION if kind == "section" else PROFILE) if all(c in rows for p in one for c in p[2]))
    figure, axes = plt.subplots(1, len(panels), figsize=(3.4 * len(panels) + 0.6, 3.4), layout="constrained")
    most = max(np.nanmax(np.abs(rows[column]), initial=0.0) for panel in panels for column in panel[2])
    for axis, (label, unit, columns) in zip(axes, panels):
        if kind == "section" and "z" not in rows:
            unit = "N/m" if unit == "N" else "N m/m"
        factor, shown = scale([rows[column] for column in columns], unit)
        axis.axhline(0.0, color="0.6", linewidth=0.8)
        for i, (column, symbol) in enumerate(columns.items()):
            values = factor * rows[column]
            axis.plot(rows["s"], values, color=f"C{i}", marker=".", markersize=4, linewidth=1.6, label=symbol)
            if len(columns) == 1:
                axis.fill_between(rows["s"], 0.0, values, color="C0", alpha=0.15, linewidth=0)
        if np.nanmax([np.nanmax(np.abs(rows[column]), initial=0.0) for column in columns]) < 1e-9 * most:
            axis.set(ylim=(-1.0, 1.0))  # rounding is not a force
        axis.set(xlabel="s (m)", ylabel=f"{label} ({shown})")
        axis.grid(alpha=0.3)
        axis.spines[["top", "right"]].set_visible(False)
        if len(columns) > 1:
            axis.legend(frameon=False)
    text = title or results.scene_title()
    figure.suptitle((text + "\n" if text else "") + f"{kind} {name}, step {number}, time {rows['time'][0]:.4g} s",
                    fontsize="medium")
    return figure
