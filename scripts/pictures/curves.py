"""Columns of the history: one axis a unit, stages as lines, the factor of safety marked."""

import re

import matplotlib.pyplot as plt
import numpy as np

from results import ResultsError

from . import style, units

TRACK = re.compile(r"track_\w+_u[xyz]")
TOGETHER = 0.05  # of the axis: names of stages would overlap
STAGE_NAMES = 9  # more stages have lines without names


def continued(results, scene, column):
    """Displacement that goes on where a stage sets it back to zero."""
    values, history = results.column(column), results.history
    if not TRACK.fullmatch(column) or "stage" not in history:
        return values
    stage, before, total = history["stage"].astype(int), 0.0, values.copy()
    for number in np.unique(stage):
        rows = np.flatnonzero(stage == number)
        if scene.stages[number - 1].resets if number <= len(scene.stages) else False:
            before = total[rows[0] - 1] if rows[0] else 0.0
        total[rows] = values[rows] + before
    return total


def read_curve(results, scene, column, since_reset):
    """Values of a column, its label and unit; settlement and time in their usual units."""
    label, unit = units.column_label(column)
    values = results.column(column) if since_reset else continued(results, scene, column)
    if column in ("time", "dt"):
        if not scene.has_time:
            return values, "pseudo-time" if column == "time" else "step of pseudo-time", ""
        seconds, unit = units.time_unit(scene, units.largest(results.column("time")))
        return values / seconds, "time" if column == "time" else "time step", unit
    return values, label, unit


def safety(results):
    """The factor of safety that the summary has; None without one."""
    try:
        return results.summary.get("factor_of_safety")
    except (ResultsError, ValueError):
        return None


def stage_starts(results, scene, x_name):
    """Where stages begin along x, and their names."""
    history = results.history
    stage = history["stage"].astype(int)
    rows = np.flatnonzero(np.diff(stage, prepend=0) > 0)
    begins = history["time"][rows] - history["dt"][rows] if x_name == "time" else history["step"][rows] - 1.0
    return [
        (begin, scene.stages[number - 1].name)
        for begin, number in zip(begins, stage[rows])
        if number <= len(scene.stages)
    ]


def draw_stages(axes, results, scene, x_name, factor):
    """A line where each stage begins, and its name; names of stages that begin close to each other stand together."""
    if x_name not in ("time", "step") or "stage" not in results.history or len(scene.stages) < 2:
        return
    starts, texts = stage_starts(results, scene, x_name), []
    span = results.history[x_name][-1]
    for begin, name in starts:
        axes.axvline(begin / factor, color="0.75", linewidth=0.7, zorder=0)
        if texts and begin - texts[-1][0] < TOGETHER * span:
            texts[-1][1].append(name)
        else:
            texts.append((begin, [name]))
    options = {"fontsize": 6.5, "color": "0.4", "ha": "left", "va": "bottom", "rotation": 30}
    for begin, together in texts if len(starts) <= STAGE_NAMES else []:
        axes.text(begin / factor, 1.01, " " + ", ".join(together), transform=axes.get_xaxis_transform(), **options)


def mark_safety(axes, results, x, x_name, columns):
    """The factor of safety as a line: upright where it is along x, else at the time that reaches it."""
    factor = safety(results)
    history = results.history
    if not factor or "reduction" not in history:
        return
    options = {"color": style.LOAD, "linewidth": 1.0, "linestyle": (0, (4, 2)), "zorder": 1}
    text = f"factor of safety {factor:.3g}"
    if x_name == "reduction":
        axes.axvline(factor, **options)
        axes.text(
            factor,
            0.02,
            text + " ",
            transform=axes.get_xaxis_transform(),
            color=style.LOAD,
            rotation=90,
            ha="right",
            va="bottom",
            fontsize=style.SMALL,
        )
    elif columns == ["reduction"]:
        axes.axhline(factor, **options)
        axes.text(
            0.02,
            factor,
            text,
            transform=axes.get_yaxis_transform(),
            color=style.LOAD,
            ha="left",
            va="bottom",
            fontsize=style.SMALL,
        )
    elif x_name in ("time", "step"):
        rows = np.flatnonzero(history["reduction"] >= factor * (1.0 - 1e-9))
        place = x[rows[0]] if len(rows) else x[-1]  # the run ends where the points begin to move
        axes.axvline(place, **options)
        axes.text(
            place,
            0.02,
            text + " ",
            transform=axes.get_xaxis_transform(),
            color=style.LOAD,
            rotation=90,
            ha="right",
            va="bottom",
            fontsize=style.SMALL,
        )


def by_unit(curves):
    """Curves in groups of one unit, in their order; those of a group in a common readable one."""
    groups = {}
    for name, values, label, unit in curves:
        groups.setdefault(unit, []).append((name, values, label))
    shown = []
    for unit, members in groups.items():
        factor, text = units.readable(max(units.largest(values) for _, values, _ in members), unit)
        shown.append((text, [(name, factor * values, label) for name, values, label in members]))
    return shown


def draw_group(axes, x, unit, members, first):
    lines = []
    for k, (_, values, label) in enumerate(members):
        marker = {"marker": ".", "markersize": 3} if len(x) < 60 else {}
        lines += axes.plot(x, values, label=label, color=style.COLOURS[(first + k) % len(style.COLOURS)], **marker)
    text = (
        members[0][2] if len(members) == 1 else ", ".join(member[2] for member in members) if len(members) < 3 else ""
    )
    axes.set_ylabel(units.with_unit(text, unit) if text else f"({unit})" if unit else "")
    return lines


def plot_history(results, scene, arguments):
    """One axis for a unit, a second one on the right for another; more units are panels one above the other."""
    columns = arguments.history
    x, x_label, x_unit = read_curve(results, scene, arguments.x, arguments.since_reset)
    curves = [(name, *read_curve(results, scene, name, arguments.since_reset)) for name in columns]
    groups, factor = by_unit(curves), 1.0
    if arguments.x != "time":
        factor, x_unit = units.readable(units.largest(x), x_unit)
    elif scene.has_time:
        factor = 1.0
    x = factor * x
    rows = len(groups) if len(groups) > 2 else 1
    figure, panels = plt.subplots(
        rows,
        1,
        sharex=True,
        squeeze=False,
        layout="constrained",
        figsize=(style.WIDTH, 3.3 if rows == 1 else 0.8 + 1.7 * rows),
    )
    seconds = units.time_unit(scene, units.largest(results.column("time")))[0] if arguments.x == "time" else 1.0
    panels = [style.open_axes(panel) for panel in panels[:, 0]]
    lines, second = draw_group(panels[0], x, *groups[0], 0), None
    if len(groups) == 2:
        second = panels[0].twinx()
        second.spines["top"].set_visible(False)
        lines += draw_group(second, x, *groups[1], len(groups[0][1]))
    for panel, group in zip(panels[1:], groups[1:] if rows > 1 else []):
        draw_group(panel, x, *group, 0)
    for number, panel in enumerate(panels):
        members = [member[0] for member in groups[number][1]]
        if number == 0:
            draw_stages(panel, results, scene, arguments.x, seconds)
        mark_safety(panel, results, x, arguments.x, members if second is None else None)
        if rows > 1 and len(members) > 1:
            panel.legend()
    if rows == 1 and len(lines) > 1:
        if second is None:
            panels[0].legend(handles=lines)
        else:
            style.legend_below(panels[0], lines)  # in neither axes is it known what the other has drawn
    panels[-1].set_xlabel(units.with_unit(x_label, x_unit))
    figure.suptitle(arguments.title or scene.title)
    return figure
