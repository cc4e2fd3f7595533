"""Forces along a row of cuts, and stress along a line: upright beside the wall where the row is upright."""

import matplotlib.pyplot as plt
import numpy as np

from results import ResultsError, find_step

from . import style, units

# Panels: label, unit, columns with their names in the legend; the first set whose columns are there.
SECTION = (
    (("normal force", "N", {"n": "N"}), ("shear force", "N", {"v": "V"}), ("bending moment", "N m", {"m": "M"})),
    (
        ("normal force", "N", {"n": "N"}),
        ("shear forces", "N", {"v1": "$V_1$", "v2": "$V_2$"}),
        ("moments", "N m", {"m1": "$M_1$", "m2": "$M_2$", "t": "T"}),
    ),
)
PROFILE = (
    (("normal stress", "Pa", {"n": "$\\sigma_n$"}), ("shear stress", "Pa", {"t": "$\\tau$"})),
    (("normal stress", "Pa", {"n": "$\\sigma_n$"}), ("shear stress", "Pa", {"t1": "$\\tau_1$", "t2": "$\\tau_2$"})),
)
STEEP = 2.0  # a row that rises so much more than it goes aside is drawn upright
NOISE = 1e-9  # of the largest number: less of a force is rounding
BESIDE = 0.6  # of the row's height: as much of the ground is drawn on either side


def rows_of(results, kind, name, step):
    """The columns of a section's or profile's file at one step, and the step."""
    table = results.table(kind, name)
    number = find_step(step, np.unique(table["step"]), f"{kind} {name}")
    chosen = table["step"] == number
    return {key: values[chosen] for key, values in table.items()}, number


def upright(rows):
    """The axis along which a row rises, y or z; None of a row that lies."""
    rise = "z" if "z" in rows else "y"
    extent = {axis: np.ptp(rows[axis]) for axis in "xyz" if axis in rows}
    aside = max(value for axis, value in extent.items() if axis != rise)
    return rise if extent[rise] > STEEP * aside else None


def draw_panel(axes, along, rows, panel, most, turned, unit):
    """One diagram: the line, filled to zero where it is one column."""
    _, _, columns = panel
    factor, shown = units.readable(max(units.largest(rows[column]) for column in columns), unit)
    (axes.axvline if turned else axes.axhline)(0.0, color=style.SOFT, linewidth=0.8)
    for k, (column, symbol) in enumerate(columns.items()):
        values, colour = factor * rows[column], style.COLOURS[k]
        axes.plot(
            *((values, along) if turned else (along, values)), color=colour, marker=".", markersize=3, label=symbol
        )
        if len(columns) == 1:
            fill = axes.fill_betweenx if turned else axes.fill_between
            fill(along, 0.0, values, color=colour, alpha=0.15, linewidth=0)
    if max(units.largest(rows[column]) for column in columns) < NOISE * most:
        axes.set(**{"xlim" if turned else "ylim": (-1.0, 1.0)})
    style.open_axes(axes)
    if len(columns) > 1:
        axes.legend()
    return shown


def draw_ground(axes, results, scene, step, rows, axis):
    """The ground beside an upright row, by materials, with the row in it."""
    from .plane import draw_groups, draw_outlines, look_at

    look = look_at(results, scene, results.state(step))
    draw_groups(axes, look, look.state["material"].astype(int), scene.materials)
    draw_outlines(axes, look, False)
    axes.plot(rows["x"], rows[axis], color=style.LOAD, linewidth=1.6, zorder=7)
    height, middle = np.ptp(rows[axis]), rows["x"].mean()
    axes.set(
        xlim=(middle - BESIDE * height, middle + BESIDE * height), aspect="equal", xlabel="x (m)", adjustable="datalim"
    )
    style.open_axes(axes)


def plot_line(results, scene, kind, name, arguments):
    """A panel each for the normal, the transverse and the turning part, along the row or the line."""
    rows, number = rows_of(results, kind, name, arguments.step)
    panels = next(
        one for one in (SECTION if kind == "section" else PROFILE) if all(c in rows for p in one for c in p[2])
    )
    rise = upright(rows)
    ground = rise == "y" and number in written(results)
    size = (1.35 * (len(panels) + ground) + 0.5, 3.6) if rise else (style.WIDTH, 1.5 * len(panels) + 0.8)
    shape = (1, len(panels) + ground) if rise else (len(panels), 1)
    figure, axes = plt.subplots(
        *shape,
        figsize=(max(size[0], 3.4), size[1]),
        layout="constrained",
        squeeze=False,
        sharex=not rise,
        sharey=bool(rise),
    )
    axes, most = axes.ravel(), max(units.largest(rows[column]) for panel in panels for column in panel[2])
    if ground:
        draw_ground(axes[0], results, scene, number, rows, rise)
    for axis, panel in zip(axes[ground:], panels):
        unit = panel[1] + ("/m" if kind == "section" and "z" not in rows else "")
        shown = draw_panel(axis, rows[rise] if rise else rows["s"], rows, panel, most, bool(rise), unit)
        axis.set(**({"xlabel": f"{panel[0]}\n({shown})"} if rise else {"ylabel": f"{panel[0]}\n({shown})"}))
    if rise:
        axes[0].set_ylabel(f"{rise} (m)")
        height = np.ptp(rows[rise])
        axes[0].set_ylim(rows[rise].min() - 0.12 * height, rows[rise].max() + 0.12 * height)
    else:
        axes[-1].set_xlabel("s (m)")
    text = arguments.title or scene.title
    stage = scene.stage_at(number)
    figure.suptitle(
        (text + "\n" if text else "")
        + f"{kind} {name}, "
        + (f"stage {stage}, " if stage else "")
        + f"step {number}, {units.time_text(scene, rows['time'][0])}"
    )
    return figure


def written(results):
    """Steps whose points were written; none without a file of points."""
    try:
        return results.steps
    except ResultsError:
        return []
