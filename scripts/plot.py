#!/usr/bin/env python3
"""Draws the results of a run of Talus: points coloured by a field, as a picture or moving, curves of the history,
forces along a row of cuts, stress along a line, or a laboratory test."""
import argparse
import re
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib import animation
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from PIL import Image
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from plot_lines import plot_line
from plot_laboratory import is_laboratory, plot_laboratory
from results import Results, ResultsError, component_names, pressure, von_mises

EXAMPLES = """examples:
  plot.py out/cantilever --field stress --component xx --deformed --output stress.png
  plot.py out/cantilever --field von_mises --step 20 --output mises.png
  plot.py out/cantilever --field stress --component xx --animate --output cantilever.gif
  plot.py out/cantilever --history track_tip_ux track_tip_uy --x load --output tip.png
  plot.py out/wall --section wall --output forces.png
  plot.py out/wall --profile base --step first --output pressure.png
  plot.py out/triaxial --measured data.csv --output triaxial.png       (a run of one point: physics stress_point)

Animations are GIF, or MP4 and others where ffmpeg is installed; they show the written states, deformed.
derived fields: von_mises and pressure (from stress), and the magnitude of vectors (no --component)."""

UNITS = {"stress": "Pa", "von_mises": "Pa", "pressure": "Pa", "displacement": "m", "position": "m", "position0": "m",
         "volume": "m³", "mass": "kg", "velocity": "m/s", "acceleration": "m/s²"}
DERIVED = {"von_mises": (von_mises, "von Mises stress"), "pressure": (pressure, "pressure")}
SYMBOLS = {"stress": "\\sigma", "displacement": "u"}
GHOST = "0.9"  # where the body was
VIEW = {"elev": 22, "azim": -60}  # degrees
LIGHT = np.array([0.35, -0.55, 0.76])  # direction to the light, of length one
FRAME_DPI = 110  # of animations
FACES = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
NORMALS = np.array([[0, 0, -1], [0, 0, 1], [0, -1, 0], [0, 1, 0], [-1, 0, 0], [1, 0, 0]])
BOX = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)])


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


def domain_corners(state, origin, corners, deformed):
    """Corners of the points' domains, (points, corners, dim): boxes, or what F makes of them. `corners` are those of a
    box of edge length two about the origin."""
    dim = state.dim
    if not deformed:
        return origin.position[:, None, :] + 0.5 * corners[None] * origin.lengths[:, None, :]
    corners = corners[None] * (state["half_length"] if "half_length" in state else 0.5 * origin.lengths)[:, None, :]
    if "F" in state:
        gradient = state["F"].reshape(-1, 3, 3)[:, :dim, :dim]
        corners = np.einsum("pij,pkj->pki", gradient, corners)
    return state["position"][:, None, :] + corners


def domain_polygons(state, origin, deformed):
    """Corners of the points' domains in the plane, (points, 4, 2)."""
    return domain_corners(state, origin, np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]), deformed)


def shell(origin):
    """Indices of the points that had no neighbour on one of their six sides at first."""
    lattice = np.rint((origin.position - origin.position.min(axis=0)) / origin.lengths[0]).astype(np.int64)
    shape = lattice.max(axis=0) + 3
    code = np.ravel_multi_index((lattice + 1).T, shape)
    inner = [np.isin(np.ravel_multi_index((lattice + 1 + step).T, shape), code) for step in NORMALS]
    return np.flatnonzero(~np.all(inner, axis=0))


def frame_of(corners, margin):
    """Limits of the axes around corners, (lower, upper)."""
    lower, upper = corners.reshape(-1, corners.shape[-1]).min(axis=0), corners.reshape(-1, corners.shape[-1]).max(axis=0)
    return lower - margin * np.max(upper - lower), upper + margin * np.max(upper - lower)


def draw_plane(figure, state, origin, values, scale, deformed, frame=None):
    axes = figure.add_subplot()
    start = polygons = domain_polygons(state, origin, False)
    if deformed:
        polygons = domain_polygons(state, origin, True)
        axes.add_collection(PolyCollection(start, facecolors=GHOST, edgecolors=GHOST, linewidths=0.25))
    colours, low, high = scale
    body = PolyCollection(polygons, array=values, cmap=colours, edgecolors="face", linewidths=0.25)
    body.set_clim(low, high)
    axes.add_collection(body)
    lower, upper = frame if frame else frame_of(np.concatenate([start, polygons]), 0.04)
    axes.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]))
    axes.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    return axes, body


def view_direction():
    """Unit vector from the scene to the eye."""
    elevation, azimuth = np.radians(VIEW["elev"]), np.radians(VIEW["azim"])
    return np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])


def draw_space(figure, state, origin, values, scale, deformed, frame=None):
    """The domains at the surface: their faces that look at the eye, with light from above."""
    axes = figure.add_subplot(projection="3d", computed_zorder=False)
    axes.set_proj_type("ortho")
    axes.view_init(**VIEW)
    corners = domain_corners(state, origin, BOX, deformed)
    lower, upper = frame if frame else frame_of(corners, 0.02)
    axes.set_box_aspect(upper - lower, zoom=0.92)
    axes.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), zlim=(lower[2], upper[2]))
    point = np.repeat(shell(origin), len(FACES))
    polygons = corners[point[:, None], np.tile(FACES, (len(point) // len(FACES), 1))]
    normal = np.cross(polygons[:, 2] - polygons[:, 0], polygons[:, 3] - polygons[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    seen = normal @ view_direction() > 0.0
    colours, low, high = scale
    mappable = ScalarMappable(Normalize(low, high), colours)
    shade = 0.72 + 0.28 * np.clip(normal[seen] @ LIGHT, 0.0, 1.0)
    paint = mappable.to_rgba(values[point[seen]])
    paint[:, :3] *= shade[:, None]
    axes.add_collection3d(Poly3DCollection(polygons[seen], facecolors=paint, edgecolors=paint, linewidths=0.4))
    axes.set(xlabel="x (m)", ylabel="y (m)", zlabel="z (m)")
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_major_locator(plt.MaxNLocator(5))
        axis.set_pane_color((0.97, 0.97, 0.97, 1.0))
    return axes, mappable


def figure_size(lower, upper):
    """Follows the picture's proportions in 2D, within reason."""
    if len(lower) == 3:
        return 8.0, 6.5
    width, height = np.maximum(upper - lower, 1e-12)
    if height < width:
        return 8.0, max(6.5 * height / width + 1.2, 2.7)
    return max(6.0 * width / height + 2.0, 4.0), 7.0


def state_frame(state, origin, deformed):
    """Limits of the axes for one state, and in the plane for its points' first places behind it."""
    corners = BOX if state.dim == 3 else BOX[:4, :2]
    drawn = domain_corners(state, origin, corners, deformed)
    if state.dim == 3:
        return frame_of(drawn, 0.02)
    return frame_of(np.concatenate([drawn, domain_corners(state, origin, corners, False)]), 0.04)


def read_points(results, step):
    """A state that has points, and where these were first."""
    state = results.state(step)
    if len(state["position"]) == 0:
        raise ResultsError(f"step {state.step} has no points")
    return state, results.origin(state)


def draw_state(figure, results, points, arguments, scale, factor_unit, frame):
    """One state with its colour bar and title; `points` as of read_points()."""
    state, origin = points
    values, label = field_values(state, arguments.field, arguments.component)
    factor, unit = factor_unit
    draw = draw_plane if state.dim == 2 else draw_space
    axes, body = draw(figure, state, origin, factor * values, scale, arguments.deformed, frame)
    figure.colorbar(body, ax=axes, shrink=0.8, aspect=25, pad=0.03 if state.dim == 2 else 0.1,
                    label=f"{label} ({unit})" if unit else label)
    where = "" if arguments.deformed else ", drawn at initial positions"
    title = arguments.title or results.scene_title()
    axes.set_title((title + "\n" if title else "") + f"step {state.step}, time {state.time:.4g} s{where}",
                   fontsize="medium")


def scale_of(values, arguments):
    """Colours and their limits, and the factor and unit of the numbers beside them."""
    shown, unit = scaled(values, UNITS.get(arguments.field, ""))
    largest = np.argmax(np.abs(values))
    factor = shown[largest] / values[largest] if values[largest] else 1.0
    return colour_scale(shown, arguments.limits, arguments.colours), (factor, unit)


def plot_points(results, arguments):
    state, origin = points = read_points(results, arguments.step)
    scale, factor_unit = scale_of(field_values(state, arguments.field, arguments.component)[0], arguments)
    frame = state_frame(state, origin, arguments.deformed)
    figure = plt.figure(figsize=figure_size(*frame), layout="constrained")
    draw_state(figure, results, points, arguments, scale, factor_unit, frame)
    return figure


def animate(results, arguments):
    """Writes the written states as a film: the same colours, limits and axes throughout."""
    arguments.deformed = True
    gif = arguments.output.lower().endswith(".gif")
    if not gif and not animation.writers.is_available("ffmpeg"):
        raise ResultsError(f"{arguments.output}: ffmpeg is not installed; without it, animations are .gif")
    values, frames = [], []
    for step in results.steps:
        state, origin = read_points(results, step)
        values.append(field_values(state, arguments.field, arguments.component)[0])
        frames.append(state_frame(state, origin, True))
    lower, upper = np.swapaxes(frames, 0, 1)
    frame = lower.min(axis=0), upper.max(axis=0)
    scale, factor_unit = scale_of(np.concatenate(values), arguments)
    figure = plt.figure(figsize=figure_size(*frame), dpi=FRAME_DPI, layout="constrained")
    pictures = []
    for step in results.steps:
        figure.clear()
        draw_state(figure, results, read_points(results, step), arguments, scale, factor_unit, frame)
        figure.canvas.draw()
        pictures.append(Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[:, :, :3].copy()))
    if gif:
        write_gif(pictures, arguments.output, arguments.fps)
    else:
        write_film(pictures, arguments.output, arguments.fps)


def write_gif(pictures, path, fps):
    """One palette for all pictures, taken from the first, the middle and the last; the last one stands for longer."""
    chosen = [np.asarray(pictures[i]) for i in (0, len(pictures) // 2, -1)]
    palette = Image.fromarray(np.concatenate(chosen)).quantize(256)
    frames = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    duration = [round(1000.0 / fps)] * (len(frames) - 1) + [round(1000.0 / fps) + 1000]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=duration, loop=0)


def write_film(pictures, path, fps):
    figure = plt.figure(figsize=np.array(pictures[0].size) / FRAME_DPI)
    writer = animation.FFMpegWriter(fps=fps)
    with writer.saving(figure, path, FRAME_DPI):
        for picture in pictures + [pictures[-1]] * int(fps):
            figure.clear()
            figure.figimage(np.asarray(picture))
            writer.grab_frame()


def column_label(name):
    """What a column of the history is, and its unit."""
    track = re.fullmatch(r"track_(\w+)_u([xyz])", name)
    reaction = re.fullmatch(r"reaction_(\w+)_(\w+)", name)
    if track:
        return f"$u_{track[2]}$ of {track[1]}", "m"
    section = re.fullmatch(r"section_(\w+)_(n|v\d?|m\d?|t)", name)
    profile = re.fullmatch(r"profile_(\w+)_(n|t\d?)", name)
    if section:
        return f"{section[2].upper()} of {section[1]}", "N m" if section[2][0] in "mt" else "N"
    if profile:
        return f"mean {profile[2]} of {profile[1]}", "Pa"
    if reaction:
        return f"reaction {reaction[2]} of {reaction[1]}", "N"
    return name.replace("_", " "), {"time": "s", "dt": "s"}.get(name, "")


def with_unit(label, unit):
    return f"{label} ({unit})" if unit else label


def plot_history(results, arguments):
    figure, axes = plt.subplots(figsize=(7.0, 4.5), layout="constrained")
    abscissa = results.column(arguments.x)
    labels = [column_label(name) for name in arguments.history]
    units = {unit for _, unit in labels}
    columns = [results.column(name) for name in arguments.history]
    shared, largest = "", np.abs(np.concatenate(columns))
    factor = 1.0
    if len(units) == 1:
        shown, shared = scaled(largest, units.pop())
        factor = shown.max() / largest.max() if largest.size and largest.max() else 1.0
    for column, (label, unit) in zip(columns, labels):
        axes.plot(abscissa, factor * column, marker="." if len(column) <= 60 else "", linewidth=1.6,
                  label=label if shared else with_unit(label, unit))
    axes.set(xlabel=with_unit(*column_label(arguments.x)))
    if len(labels) == 1:
        axes.set(ylabel=with_unit(labels[0][0], shared))
    else:
        axes.legend(frameon=False)
        axes.set(ylabel=f"({shared})" if shared else "")
    axes.set_title(arguments.title or results.scene_title(), fontsize="medium")
    axes.grid(alpha=0.3)
    axes.spines[["top", "right"]].set_visible(False)
    return figure


class TitledResults(Results):
    def scene_title(self):
        """The scene's title; nothing where there is none."""
        try:
            return self.option("mpm_title", "")
        except ResultsError:
            return ""


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, epilog=EXAMPLES,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("prefix", help="what the names of the result files start with, like out/cantilever")
    parser.add_argument("--field", default="displacement", help="what the points are coloured by (displacement)")
    parser.add_argument("--component", help="xx, yy, zz, xy, yz, xz of a tensor; x, y, z of a vector")
    parser.add_argument("--step", default="last", help="first, last, or the number of a written step (last)")
    parser.add_argument("--deformed", action="store_true", help="draw the points where they are at that step")
    parser.add_argument("--animate", action="store_true", help="all written states as a film (.gif; .mp4 with ffmpeg)")
    parser.add_argument("--fps", type=float, default=8.0, help="pictures a second of a film (8)")
    parser.add_argument("--history", nargs="+", metavar="COLUMN", help="draw columns of the history instead of points")
    parser.add_argument("--section", metavar="NAME", help="draw N, V and M along a row of cuts at --step")
    parser.add_argument("--profile", metavar="NAME", help="draw normal and shear stress along a line at --step")
    parser.add_argument("--x", default="time", metavar="COLUMN", help="the column along the x axis (time)")
    parser.add_argument("--measured", metavar="FILE.csv",
                        help="measurements beside a laboratory test: columns strain_yy, p, q, eps_v, e, signs as in the "
                             "history")
    parser.add_argument("--limits", nargs=2, type=float, metavar=("LOW", "HIGH"),
                        help="ends of the colour bar, in its unit (the field's extremes)")
    parser.add_argument("--colours", metavar="MAP", help="a colour map of matplotlib")
    parser.add_argument("--title", help="the picture's title (the scene's)")
    parser.add_argument("--output", help="file; its ending tells the format (plot.png, or plot.gif of a film)")
    arguments = parser.parse_args(arguments)
    arguments.output = arguments.output or ("plot.gif" if arguments.animate else "plot.png")
    return arguments


def draw(results, arguments):
    if arguments.history:
        return plot_history(results, arguments)
    for kind in ("section", "profile"):
        if getattr(arguments, kind):
            return plot_line(results, kind, getattr(arguments, kind), arguments.step, arguments.title)
    if arguments.measured and not is_laboratory(results):
        raise ResultsError("--measured: measurements go with a laboratory test, physics stress_point")
    if is_laboratory(results):
        return plot_laboratory(results, arguments.measured, arguments.title)
    return plot_points(results, arguments)


def main(arguments=None):
    arguments = parse(arguments)
    results = TitledResults(arguments.prefix)
    try:
        if arguments.colours and arguments.colours not in plt.colormaps():
            raise ResultsError(f"matplotlib has no colour map '{arguments.colours}'")
        if arguments.animate:
            animate(results, arguments)
        else:
            figure = draw(results, arguments)
            figure.savefig(arguments.output, dpi=150, bbox_inches="tight")
    except (ResultsError, OSError, ValueError) as error:
        print(f"plot.py: {error}", file=sys.stderr)
        return 2
    print(arguments.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
