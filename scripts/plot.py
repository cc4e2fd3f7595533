#!/usr/bin/env python3
"""Draws the results of a run of Talus: points coloured by a field, or curves from the history."""
import argparse
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection

from results import Results, ResultsError, component_names, initial_lengths, pressure, von_mises

EXAMPLES = """examples:
  plot.py out/cantilever --field stress --component xx --deformed --output stress.png
  plot.py out/cantilever --field von_mises --step 20 --output mises.png
  plot.py out/cantilever --history track_tip_ux track_tip_uy --x load --output tip.png

derived fields: von_mises and pressure (from stress), and the magnitude of vectors (no --component)."""

UNITS = {"stress": "Pa", "von_mises": "Pa", "pressure": "Pa", "displacement": "m", "position": "m", "position0": "m",
         "volume": "m³", "mass": "kg", "velocity": "m/s", "acceleration": "m/s²"}
DERIVED = {"von_mises": (von_mises, "von Mises stress"), "pressure": (pressure, "pressure")}
SYMBOLS = {"stress": "\\sigma", "displacement": "u"}
GHOST = "0.9"  # where the body was


def scaled(values, unit):
    """Values and unit with a metric prefix that keeps a colour bar readable."""
    largest = np.max(np.abs(values[np.isfinite(values)]), initial=0.0)
    if unit in ("Pa", "N"):
        for factor, prefix in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
            if largest >= factor:
                return values / factor, prefix + unit
    return values, unit


def field_values(state, field, component):
    """One number a point, and its label without unit."""
    if field in DERIVED and field not in state:
        derive, label = DERIVED[field]
        return derive(state["stress"]), label
    data = state[field]
    data = data.reshape(len(data), -1)
    names = component_names(data.shape[1])
    symbol = SYMBOLS.get(field, f"\\mathrm{{{field}}}")
    if data.shape[1] == 1:
        return data[:, 0].astype(float), field.replace("_", " ")
    if component is None:
        if data.shape[1] > 3:
            raise ResultsError(f"field '{field}' is a tensor: choose a --component out of {', '.join(names)}")
        return np.linalg.norm(data, axis=1), f"$|{symbol}|$"
    if component not in names:
        raise ResultsError(f"field '{field}' has no component '{component}'; it has {', '.join(names)}")
    return data[:, names.index(component)], f"${symbol}_{{{component}}}$"


def colour_scale(values, limits, colours):
    """Colour map and limits: symmetric and diverging where the field clearly takes both signs."""
    low, high = limits if limits else (np.min(values), np.max(values))
    if not limits and low < 0.0 < high and min(-low, high) > 0.1 * max(-low, high):
        high = max(-low, high)
        return colours or "coolwarm", -high, high
    return colours or "viridis", low, high if high > low else low + 1.0


def domain_polygons(state, initial, deformed):
    """Corners of the points' domains, (points, 4, 2): rectangles, or the parallelograms that F makes of them."""
    corners = 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])[None] * initial_lengths(initial)[:, None, :]
    if not deformed:
        return initial["position0"][:, None, :] + corners
    if "F" in state:
        gradient = state["F"].reshape(-1, 3, 3)[:, :2, :2]
        corners = np.einsum("pij,pkj->pki", gradient, corners)
    return state["position"][:, None, :] + corners


def draw_plane(figure, state, initial, values, scale, deformed):
    axes = figure.add_subplot()
    start = polygons = domain_polygons(state, initial, False)
    if deformed:
        polygons = domain_polygons(state, initial, True)
        axes.add_collection(PolyCollection(start, facecolors=GHOST, edgecolors=GHOST, linewidths=0.25))
    colours, low, high = scale
    body = PolyCollection(polygons, array=values, cmap=colours, edgecolors="face", linewidths=0.25)
    body.set_clim(low, high)
    axes.add_collection(body)
    corners = np.concatenate([start, polygons])
    lower, upper = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    margin = 0.04 * np.max(upper - lower)
    axes.set(xlim=(lower[0] - margin, upper[0] + margin), ylim=(lower[1] - margin, upper[1] + margin))
    axes.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    return axes, body


def draw_space(figure, state, initial, values, scale, deformed):
    axes = figure.add_subplot(projection="3d")
    axes.set_proj_type("ortho")
    position = state["position"] if deformed else initial["position0"]
    lower, upper = position.min(axis=0), position.max(axis=0)
    extent = np.maximum(upper - lower, 1e-12)
    axes.set_box_aspect(extent)
    axes.view_init(elev=22, azim=-60)
    # A marker about as wide as a domain: the box fills some 60 % of the figure's shorter side.
    points_per_metre = 0.6 * 72 * min(figure.get_size_inches()) / np.linalg.norm(extent)
    size = (1.5 * points_per_metre * np.mean(initial_lengths(initial), axis=1)) ** 2
    colours, low, high = scale
    body = axes.scatter(*position.T, c=values, s=np.maximum(size, 1.0), marker="o", cmap=colours, vmin=low, vmax=high,
                        depthshade=False, linewidths=0, alpha=1.0)
    axes.set(xlabel="x (m)", ylabel="y (m)", zlabel="z (m)")
    return axes, body


def figure_size(state, initial, deformed):
    """Follows the body's proportions in 2D, within reason."""
    if state.dim == 3:
        return 8.0, 6.5
    position = np.concatenate([initial["position0"], state["position"]]) if deformed else initial["position0"]
    width, height = np.maximum(np.ptp(position, axis=0), 1e-12)
    if height < width:
        return 8.0, max(6.5 * height / width + 1.0, 2.5)
    return max(6.0 * width / height + 2.0, 4.0), 7.0


def plot_points(results, arguments):
    state, initial = results.state(arguments.step), results.initial
    if len(state["position"]) == 0:
        raise ResultsError(f"step {state.step} has no points")
    if len(state["position"]) != len(initial["position0"]):
        raise ResultsError("the number of points changed during the run: there are no initial domains to draw with")
    values, label = field_values(state, arguments.field, arguments.component)
    values, unit = scaled(values, UNITS.get(arguments.field, ""))
    scale = colour_scale(values, arguments.limits, arguments.colours)
    figure = plt.figure(figsize=figure_size(state, initial, arguments.deformed), layout="constrained")
    draw = draw_plane if state.dim == 2 else draw_space
    axes, body = draw(figure, state, initial, values, scale, arguments.deformed)
    figure.colorbar(body, ax=axes, shrink=0.8, label=f"{label} ({unit})" if unit else label)
    title = arguments.title or results.options_title()
    where = "" if arguments.deformed else ", drawn at initial positions"
    axes.set_title(f"{title}step {state.step}, time {state.time:g}{where}", fontsize="medium")
    return figure


def column_label(name):
    for start, unit in (("track_", "m"), ("reaction_", "N"), ("time", "s"), ("dt", "s")):
        if name.startswith(start):
            return f"{name} ({unit})"
    return name


def plot_history(results, arguments):
    figure, axes = plt.subplots(figsize=(7.0, 4.5), layout="constrained")
    abscissa = results.column(arguments.x)
    for name in arguments.history:
        axes.plot(abscissa, results.column(name), marker=".", label=column_label(name))
    axes.set(xlabel=column_label(arguments.x))
    if len(arguments.history) == 1:
        axes.set(ylabel=column_label(arguments.history[0]))
    else:
        axes.legend()
    axes.set_title(arguments.title or results.options_title().rstrip(": "), fontsize="medium")
    axes.grid(alpha=0.3)
    return figure


class TitledResults(Results):
    def options_title(self):
        """The scene's title as the start of a line; nothing where there is none."""
        try:
            title = self.option("mpm_title", "")
        except ResultsError:
            title = ""
        return f"{title}: " if title else ""


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, epilog=EXAMPLES,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("prefix", help="what the names of the result files start with, like out/cantilever")
    parser.add_argument("--field", default="displacement", help="what the points are coloured by (displacement)")
    parser.add_argument("--component", help="xx, yy, zz, xy, yz, xz of a tensor; x, y, z of a vector")
    parser.add_argument("--step", default="last", help="first, last, or the number of a written step (last)")
    parser.add_argument("--deformed", action="store_true", help="draw the points where they are at that step")
    parser.add_argument("--history", nargs="+", metavar="COLUMN", help="draw columns of the history instead of points")
    parser.add_argument("--x", default="time", metavar="COLUMN", help="the column along the x axis (time)")
    parser.add_argument("--limits", nargs=2, type=float, metavar=("LOW", "HIGH"),
                        help="ends of the colour bar, in its unit (the field's extremes)")
    parser.add_argument("--colours", metavar="MAP", help="a colour map of matplotlib")
    parser.add_argument("--title", help="the picture's title (the scene's)")
    parser.add_argument("--output", default="plot.png", help="picture file; its ending tells the format (plot.png)")
    return parser.parse_args(arguments)


def main(arguments=None):
    arguments = parse(arguments)
    results = TitledResults(arguments.prefix)
    try:
        if arguments.colours and arguments.colours not in plt.colormaps():
            raise ResultsError(f"matplotlib has no colour map '{arguments.colours}'")
        figure = plot_history(results, arguments) if arguments.history else plot_points(results, arguments)
        figure.savefig(arguments.output, dpi=150, bbox_inches="tight")
    except (ResultsError, OSError, ValueError) as error:
        print(f"plot.py: {error}", file=sys.stderr)
        return 2
    print(arguments.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
