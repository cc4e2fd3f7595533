"""A scene before any run: bodies by material, conditions, boundaries, loads, tracks, water and the grid."""

import textwrap

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.patches import Patch, Polygon

from results import ResultsError

from . import marks, style
from .plane import draw_groups, draw_outlines, look_at, set_frame
from .space import draw_space_groups, space_frame
from .states import TITLE, figure_size, new_axes, read_points

LINES = 60  # of the grid along an axis; finer grids show every second, third or so


def grid_lines(scene):
    """Lines of the grid in the plane, (k, 2, 2)."""
    low, high = scene.vector("grid_lower")[:2], scene.vector("grid_upper")[:2]
    cells = (scene.vector("grid_cells")[:2] * float(scene.get("grid_refine", "1"))).astype(int)
    every = max(1, -(-int(cells.max()) // LINES))
    x, y = (np.linspace(low[axis], high[axis], cells[axis] + 1)[::every] for axis in range(2))
    return [((a, low[1]), (a, high[1])) for a in x] + [((low[0], b), (high[0], b)) for b in y], every


def draw_joining(axes, scene):
    """Bodies that join a stage, dashed, with its name."""
    handles = []
    for body in scene.bodies():
        if body.joins and body.polygon is not None:
            stage = next(stage.name for stage in scene.stages if body.name in scene.list(f"stage_{stage.name}_bodies"))
            colour = (
                style.material_colour(scene.materials.index(body.material))
                if body.material in scene.materials
                else "0.9"
            )
            axes.add_patch(
                Polygon(
                    body.polygon,
                    facecolor=colour,
                    alpha=0.45,
                    edgecolor=style.INK,
                    linestyle=(0, (3, 2)),
                    linewidth=0.7,
                    zorder=2.5,
                )
            )
            style.name(
                axes,
                *body.polygon.mean(axis=0),
                body.name + ", joins" + (f" in {stage}" if stage != body.name else ""),
                fontsize=6.5,
            )
            handles.append(body.material)
    return handles


def box_of(scene, look):
    """The frame: the material, the bodies that join, and the water; not the empty grid above."""
    corners = [look.domains.corners.reshape(-1, 2)] + [
        body.polygon for body in scene.bodies() if body.polygon is not None
    ]
    corners += [
        line for line in [scene.water_line(0.0, *look.domains.corners[..., 0].ravel()[[0, -1]])] if line is not None
    ]
    corners = np.concatenate(corners)
    for name in scene.list("boundaries"):
        found = scene.boundary_outline(name, 0.0, 0.0)
        if found is not None and scene.get(f"boundary_{name}_side", "outside") == "outside":
            corners = np.concatenate([corners, found[0]])
    margin = 0.09 * np.max(np.ptp(corners, axis=0))
    return corners.min(axis=0) - margin, corners.max(axis=0) + margin


def notes(scene):
    """Conditions that no symbol shows, in words."""
    lines = []
    for name in scene.list("bcs"):
        kind, components = scene.get(f"bc_{name}_region", "all"), ", ".join(scene.list(f"bc_{name}_components"))
        if kind == "all" and components:
            lines.append(f"condition {name}: {components} at all nodes")
    gravity = [name for name in scene.list("loads") if scene.get(f"load_{name}_type") == "gravity"]
    lines += [f"gravity {np.linalg.norm(scene.vector(f'load_{name}_value')):.4g} m/s²" for name in gravity]
    return lines


def all_of(scene, kind):
    """Names of all conditions or the like, those of stages too."""
    listed = scene.list(kind) + [name for stage in scene.stages for name in scene.list(f"stage_{stage.name}_{kind}")]
    return [name for name in dict.fromkeys(listed) if name not in ("none",)]


class WholeScene:
    """A scene in which all conditions, loads and surfaces of all stages act at once."""

    def __init__(self, scene):
        self.scene = scene

    def __getattr__(self, name):
        return getattr(self.scene, name)

    def active(self, kind, _stage):
        return all_of(self.scene, kind)


def plot_scene(results, scene, arguments):
    """The figure of a scene in its first state."""
    if scene.get("physics") == "stress_point":
        raise ResultsError("a laboratory test has no picture before its run")
    state = read_points(results, "first")
    if state.dim == 3:
        return plot_space(results, scene, state, arguments)
    look = look_at(results, scene, state, False)
    look = marks.widen(look._replace(frame=box_of(scene, look)), WholeScene(scene), None, None)
    figure = plt.figure(figsize=figure_size(look.frame, 1.1), layout="constrained")
    axes = new_axes(figure, True)
    lines, every = grid_lines(scene)
    axes.add_collection(LineCollection(lines, colors="0.85", linewidths=0.4, zorder=0), autolim=False)
    axes.add_collection(LineCollection(lines, colors="0.0", alpha=0.10, linewidths=0.3, zorder=2.8), autolim=False)
    shown = draw_groups(axes, look, state["material"].astype(int), scene.materials)
    draw_outlines(axes, look, False)
    joining = draw_joining(axes, scene)
    marks.draw_marks(axes, look, WholeScene(scene), None)
    marks.draw_tracks(axes, look, scene)
    set_frame(axes, look.frame, scene.axial)
    handles = [Patch(facecolor=colour, edgecolor=style.INK, linewidth=0.5, label=text) for colour, text in shown]
    handles += [
        Patch(facecolor=style.material_colour(scene.materials.index(name)), alpha=0.5, label=name)
        for name in dict.fromkeys(joining)
        if name in scene.materials and name not in [text for _, text in shown]
    ]
    style.legend_below(axes, handles)
    words = notes(scene) + ([f"one line of the grid in {every} is drawn"] if every > 1 else [])
    if words:
        axes.text(
            0.01,
            0.99,
            "\n".join(words),
            transform=axes.transAxes,
            va="top",
            ha="left",
            fontsize=6.5,
            color="0.35",
            path_effects=style.HALO,
            zorder=9,
        )
    title = arguments.title or scene.title
    figure.suptitle("\n".join(textwrap.wrap(title, TITLE)))
    return figure


def plot_space(results, scene, state, arguments):
    """A scene in space: its surface by material."""
    figure = plt.figure(figsize=figure_size(space_frame(results, state, arguments)), layout="constrained")
    axes = new_axes(figure, False)
    draw_space_groups(axes, results, state, (state["material"].astype(int), scene.materials), arguments)
    figure.suptitle("\n".join(textwrap.wrap(arguments.title or scene.title, TITLE)))
    return figure
