"""One state, or several beside each other: the material by colour, with all that acts on it."""

import textwrap

import matplotlib.pyplot as plt
import numpy as np

from results import ResultsError

from . import fields, marks, style, units
from .plane import bar, bodies_of, draw_arrows, draw_contours, draw_groups, draw_outlines, look_at, paint, set_frame
from .slices import slice_look
from .space import draw_space, draw_space_groups, space_frame

COLUMNS = 3  # of small multiples, at most
TITLE = 62  # letters a line


def read_points(results, step):
    """A state that has points."""
    state = results.state(step)
    if len(state["position"]) == 0:
        raise ResultsError(f"step {state.step} has no points")
    return state


def title_of(scene, state, arguments, whole=True):
    """Title of a picture: the scene's, then stage, step and time."""
    stage = scene.stage_at(state.step)
    parts = ([f"stage {stage}"] if stage else []) + [f"step {state.step}", units.time_text(scene, state.time)]
    if arguments.initial:
        parts.append("drawn at first places")
    elif arguments.scale != 1.0:
        parts.append(f"displacement times {arguments.scale:g}")
    if not whole:
        return (f"{stage}, " if stage else "") + units.time_text(scene, state.time)
    text = arguments.title or scene.title
    return ("\n".join(textwrap.wrap(text, TITLE)) + "\n" if text else "") + ", ".join(parts)


def look_of(results, scene, state, arguments):
    """Geometry of a state: of the plane, or of a slice; None of a body in space."""
    if state.dim == 2:
        if arguments.slice:
            raise ResultsError("--slice: goes with a body in space")
        look = look_at(results, scene, state, not arguments.initial, arguments.scale)
        return look if arguments.plain else marks.widen(look, scene, state.time, scene.stage_at(state.step))
    return slice_look(results, scene, state, arguments.slice) if arguments.slice else None


def figure_size(frame, room=1.0):
    """Follows the picture's proportions in the plane, within reason."""
    if len(frame[0]) == 3:
        return style.WIDTH, 4.2
    width, height = np.maximum(frame[1] - frame[0], 1e-12)
    if height < width:
        return style.WIDTH, float(np.clip((style.WIDTH - 1.3) * height / width + 0.95, 1.9, 5.6)) * room
    return float(np.clip(3.9 * width / height + 1.5, 2.9, style.WIDTH)), 4.9


def group_field(results, scene, state, arguments):
    """Numbers and names of a field that names materials or bodies; None for other fields."""
    if arguments.field == "material":
        return state["material"].astype(int), scene.materials
    if arguments.field == "body":
        return bodies_of(scene, state, results.origin(state))[0], [body.name for body in scene.bodies()]
    return None


def draw_state(figure, axes, results, scene, state, arguments, series=None):
    """One state in its axes; `series`: (scale, size, frame) of several states. Scale, if it needs a bar, and label."""
    scale, size, frame = series or (None, None, None)
    groups, look = group_field(results, scene, state, arguments), look_of(results, scene, state, arguments)
    if groups is None:
        field = fields.read_field(look.state if look else state, arguments.field, arguments.component, size)
        scale = scale or fields.colour_scale(field.values, arguments.limits, arguments.colours)
        flat = field.uniform and not series and not arguments.limits
    if look is None and groups is not None:
        draw_space_groups(axes, results, state, groups, arguments, frame)
        return None, None
    if look is None:
        draw_space(axes, results, state, field.values, scale, arguments, frame)
        return scale, field.label
    if groups is not None:
        numbers = groups[0] if look.state is state else groups[0][look.rows]
        handles = [
            plt.Rectangle((0, 0), 1, 1, color=colour, label=text)
            for colour, text in draw_groups(axes, look, numbers, groups[1])
        ]
        axes.legend(handles=handles, loc="best", title=arguments.field)
    elif flat:
        draw_uniform(axes, look, field)
    else:
        paint(axes, look, field.values, scale)
        if arguments.contours and state.dim == 2:
            draw_contours(axes, look, field.values, scale, arguments.contours)
    draw_outlines(axes, look, not arguments.initial and arguments.scale != 0.0)
    set_frame(axes, frame or look.frame, scene.axial)
    if state.dim == 3:
        axes.set(xlabel=f"{look.axes[0]} (m)", ylabel=f"{look.axes[1]} (m)")
        return (None if groups is not None or flat else scale), None if groups is not None else field.label
    draw_over(axes, look, scene, state, arguments, series is None)
    return (None if groups is not None or flat else scale), None if groups is not None else field.label


def draw_over(axes, look, scene, state, arguments, names):
    """Arrows of a field, and the marks of what acts; names only where there is room for them."""
    if arguments.arrows:
        draw_arrows(axes, look, arguments.arrows)
    if not arguments.plain:
        marks.draw_marks(axes, look, scene, state.time, scene.stage_at(state.step), names and not arguments.arrows)


def draw_uniform(axes, look, field):
    """A field of one number is one colour, which a line names."""
    paint(axes, look, np.full(len(field.values), 0.5), fields.Scale(style.SEQUENTIAL, 0.0, 1.0))
    value = float(np.mean(field.values)) if len(field.values) else 0.0
    value = 0.0 if abs(value) < units.NOISE else value
    name = field.label.removesuffix(f" ({field.unit})")
    axes.text(
        0.99,
        0.98,
        f"{name} = {value:.4g} {field.unit} everywhere".replace("  ", " "),
        transform=axes.transAxes,
        ha="right",
        va="top",
        fontsize=style.SMALL,
        path_effects=style.HALO,
        zorder=9,
    )


def new_axes(figure, flat, *place):
    if flat:
        return figure.add_subplot(*place)
    return figure.add_subplot(*place, projection="3d", computed_zorder=False)


def plot_state(results, scene, arguments):
    """A figure of one state."""
    state = read_points(results, arguments.step)
    look = look_of(results, scene, state, arguments)
    figure = plt.figure(
        figsize=figure_size(look.frame if look else space_frame(results, state, arguments)), layout="constrained"
    )
    axes = new_axes(figure, look is not None)
    scale, label = draw_state(figure, axes, results, scene, state, arguments)
    if scale:
        bar(figure, axes, scale, label, **({} if look else {"pad": 0.1}))
    figure.suptitle(title_of(scene, state, arguments))
    return figure


def common(results, scene, steps, arguments, percentile=None):
    """Colours, size of the unit and limits of the axes that states have in common, and the states."""
    states = [read_points(results, step) for step in steps]
    looks = [look_of(results, scene, state, arguments) for state in states]
    frames = [look.frame if look else space_frame(results, state, arguments) for look, state in zip(looks, states)]
    frame = np.min([one[0] for one in frames], axis=0), np.max([one[1] for one in frames], axis=0)
    if arguments.field in fields.GROUPS:
        return states, (None, None, frame)
    raw = [
        fields.field_values(look.state if look else state, arguments.field, arguments.component)[0]
        for look, state in zip(looks, states)
    ]
    size = max(units.largest(values) for values in raw)
    shown = [
        fields.read_field(look.state if look else state, arguments.field, arguments.component, size).values
        for look, state in zip(looks, states)
    ]
    return states, (
        fields.colour_scale(np.concatenate(shown), arguments.limits, arguments.colours, percentile),
        size,
        frame,
    )


def chosen_steps(results, text):
    """Steps of --steps: one number N means N states spread evenly over the run; several are steps."""
    steps = results.steps
    if len(text) > 1:
        return text
    if not text[0].isdigit() or int(text[0]) < 1:
        raise ResultsError(f"--steps {text[0]}: give a number of states, or several steps")
    return [steps[k] for k in np.unique(np.linspace(0, len(steps) - 1, int(text[0])).round().astype(int))]


def plot_multiples(results, scene, arguments):
    """Small multiples: several states with the same colours and axes."""
    steps = chosen_steps(results, arguments.steps)
    states, series = common(results, scene, steps, arguments)
    frame = series[2]
    wide = len(frame[0]) == 2 and (frame[1] - frame[0])[0] > 1.4 * (frame[1] - frame[0])[1]
    columns = min(2 if wide else COLUMNS, len(states))
    rows = -(-len(states) // columns)
    ratio = (frame[1] - frame[0])[1] / (frame[1] - frame[0])[0] if len(frame[0]) == 2 else 0.9
    height = float(np.clip((style.WIDTH - 1.2) / columns * ratio + 0.35, 0.8, 4.0)) * rows + 0.6
    figure = plt.figure(figsize=(style.WIDTH, height), layout="constrained")
    every, label, scale = [], None, None
    for k, state in enumerate(states):
        axes = new_axes(figure, len(frame[0]) == 2, rows, columns, k + 1)
        scale, label = draw_state(figure, axes, results, scene, state, arguments, series)
        axes.set_title(title_of(scene, state, arguments, False), fontsize=style.SMALL)
        if len(frame[0]) == 2:
            axes.label_outer()
            if k + columns >= len(states):
                axes.set_xlabel("x (m)")
                axes.tick_params(labelbottom=True)
        every.append(axes)
    if scale:
        bar(figure, every, scale, label, shrink=0.7)
    figure.suptitle(arguments.title or scene.title)
    return figure
