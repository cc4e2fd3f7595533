"""Flow over terrain, from the maps of a run: the bed as hillshade with contours, a field over it, outlines of release and
deposit, gauges; as a picture or a film.

Hillshade: Horn (1981), Proc. IEEE 69, 14-47, with light from the north-west, 45 degrees high."""

import re

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D

from maps import map_steps, read_map
from results import ResultsError

from . import style
from .film import FRAME_DPI, FRAMES, pixels, wipe, write_film, write_gif

AZIMUTH, ALTITUDE = np.radians(315.0), np.radians(45.0)
LEAST = 0.01  # of the largest depth: what is thinner is not drawn
LINES = 12  # contours of the bed
RELEASE, DEPOSIT = "#0072B2", "#D55E00"
UNITS = {"depth": "m", "depth_normal": "m", "deposit": "m", "deposit_normal": "m", "bed": "m", "bed_change": "m", "speed": "m/s",
         "velocity_x": "m/s", "velocity_y": "m/s", "pressure": "kPa", "arrival": "s"}


def shade(bed, dx, dy):
    """Light on a bed, 0 to 1; rows from south to north."""
    rise_y, rise_x = np.gradient(bed, dy, dx)
    light = np.array([np.sin(AZIMUTH) * np.cos(ALTITUDE), np.cos(AZIMUTH) * np.cos(ALTITUDE), np.sin(ALTITUDE)])
    return np.clip((-rise_x * light[0] - rise_y * light[1] + light[2]) / np.sqrt(1.0 + rise_x**2 + rise_y**2), 0.0, 1.0)


def edges(x):
    half = 0.5 * (x[1] - x[0]) if len(x) > 1 else 0.5
    return x[0] - half, x[-1] + half


def step_of(bed):
    """A round distance of contours, m."""
    reach = np.nanmax(bed) - np.nanmin(bed)
    if not reach > 0.0:
        return None
    power = 10.0 ** np.floor(np.log10(reach / LINES))
    return power * min((1, 2, 5, 10), key=lambda factor: abs(np.log(factor * power * LINES / reach)))


def draw_bed(axes, field):
    """Hillshade, and contours with their heights."""
    bed, extent = field.bands["bed"], (*edges(field.x), *edges(field.y))
    light = shade(bed, field.x[1] - field.x[0], field.y[1] - field.y[0])
    axes.imshow(light, cmap="gray", origin="lower", extent=extent, vmin=-0.3, vmax=1.0, zorder=1)
    step = step_of(bed)
    if step:
        levels = np.arange(np.ceil(np.nanmin(bed) / step), np.nanmax(bed) / step + 1e-9) * step
        if len(levels):
            lines = axes.contour(field.x, field.y, bed, levels, colors="0.25", linewidths=0.4, zorder=3)
            axes.clabel(lines, fontsize=style.TINY, fmt="%g", inline_spacing=2)
    axes.set(aspect="equal", xlim=extent[:2], ylim=extent[2:], xlabel="x (m)", ylabel="y (m)")


def draw_outline(axes, field, depth, least, colour):
    """The line at a depth."""
    if np.nanmax(depth) > least:
        axes.contour(field.x, field.y, np.nan_to_num(depth), [least], colors=colour, linewidths=1.1, zorder=5)


def draw_gauges(axes, results):
    """Gauges of the scene with their names."""
    names = re.split(r"\s*,\s*", results.option("mpm_gauges")) if results.is_given("mpm_gauges") else []
    for name in names:
        for kind in ("place", "line", "outline", "path"):
            if not results.is_given(f"mpm_gauge_{name}_{kind}"):
                continue
            places = np.array(results.numbers(f"mpm_gauge_{name}_{kind}")).reshape(-1, 2)
            closed = np.vstack([places, places[:1]]) if kind == "outline" else places
            axes.plot(*closed.T, {"place": "o", "path": ":"}.get(kind, "-"), color=style.INK, markersize=3, linewidth=1.0, zorder=6)
            style.name(axes, *places[0], name, ha="left", va="bottom")


def values_of(field, name):
    """A band as it is drawn, and the label of its bar."""
    names = [band for band in field.bands if band == name or (name == "arrival" and band.startswith("arrival_"))]
    if not names:
        raise ResultsError(f"the map has no band '{name}'; it has {', '.join(field.bands)}")
    unit = UNITS.get(name.split("_")[0] if name.startswith("arrival") else name, "")
    value = field.bands[names[0]] * (1e-3 if unit == "kPa" else 1.0)
    return value, f"{names[0].replace('_', ' ')} ({unit})"


def field_name(arguments):
    return "depth" if arguments.field == "displacement" else arguments.field


def draw(axes, field, arguments, least, limits):
    """The field where there is material; the image."""
    value, label = values_of(field, field_name(arguments))
    depth = field.bands["depth"]
    return axes.imshow(np.ma.masked_where(~(depth > least) | np.isnan(value), value), origin="lower", zorder=2,
                       extent=(*edges(field.x), *edges(field.y)), cmap=arguments.colours or style.SEQUENTIAL,
                       vmin=limits[0], vmax=limits[1], alpha=0.85), label


def stems(results, arguments):
    """The map that is drawn, and that of the release, or None."""
    steps = map_steps(results.prefix)
    if arguments.step == "last":
        stem = f"{results.prefix}_peak"
    else:
        number = {"first": steps[0]}.get(arguments.step, arguments.step) if steps else arguments.step
        stem = f"{results.prefix}_{int(number):06d}"
    return stem, f"{results.prefix}_{steps[0]:06d}" if steps and steps[0] == 0 else None


def limits_of(value, arguments):
    return arguments.limits or (0.0, max(float(np.nanmax(np.append(value.ravel(), 0.0))), 1e-12))


def plot_terrain(results, _, arguments):
    """A field of the largest values of a run, or of a step, over its bed."""
    stem, first = stems(results, arguments)
    field = read_map(stem)
    least = LEAST * np.nanmax(field.bands["depth"])
    width, height = np.ptp(edges(field.x)), np.ptp(edges(field.y))
    figure, axes = plt.subplots(figsize=(style.WIDTH + 1.2, (style.WIDTH) * min(max(height / width, 0.3), 1.5) + 0.9),
                                layout="constrained")
    draw_bed(axes, field)
    image, label = draw(axes, field, arguments, least, limits_of(values_of(field, field_name(arguments))[0], arguments))
    figure.colorbar(image, ax=axes, label=label, shrink=0.85)
    handles = []
    if first:
        draw_outline(axes, read_map(first), read_map(first).bands["depth"], least, RELEASE)
        handles.append(Line2D([], [], color=RELEASE, label="release"))
    if "deposit" in field.bands:
        draw_outline(axes, field, field.bands["deposit"], least, DEPOSIT)
        handles.append(Line2D([], [], color=DEPOSIT, label="last state"))
    if handles:
        axes.legend(handles=handles, loc="upper right", frameon=True, framealpha=0.8)
    if not arguments.plain:
        draw_gauges(axes, results)
    axes.set_title(arguments.title or results.option("mpm_title", ""))
    return figure


def frames(results, arguments):
    """The states that have maps, one after the other."""
    steps = map_steps(results.prefix)
    if not steps:
        raise ResultsError(f"there are no maps of states beside {results.prefix}: the run needs -mpm_maps_every")
    steps = [steps[k] for k in np.unique(np.linspace(0, len(steps) - 1, min(len(steps), FRAMES)).round().astype(int))]
    states = [read_map(f"{results.prefix}_{step:06d}") for step in steps]
    name, history = field_name(arguments), results.history
    limits = limits_of(np.array([np.nanmax(values_of(state, name)[0]) for state in states]), arguments)
    least = LEAST * max(np.nanmax(state.bands["depth"]) for state in states)
    width, height = np.ptp(edges(states[0].x)), np.ptp(edges(states[0].y))
    figure, axes = plt.subplots(figsize=(style.WIDTH + 1.2, style.WIDTH * min(max(height / width, 0.3), 1.5) + 0.9),
                                dpi=FRAME_DPI, layout="constrained")
    for number, (step, state) in enumerate(zip(steps, states)):
        wipe(axes)
        for picture in list(axes.images):
            picture.remove()
        draw_bed(axes, state)
        image, label = draw(axes, state, arguments, least, limits)
        time = np.interp(step, np.append(0, history["step"]), np.append(0.0, history["time"]))
        axes.set_title(f"{arguments.title or results.option('mpm_title', '')} {time:.3g} s".strip())
        if not number:
            figure.colorbar(image, ax=axes, label=label, shrink=0.85)
            style.settle(figure)
        yield pixels(figure)
        figure.set_layout_engine("none")


def film_terrain(results, arguments):
    """All states that have maps, as a film."""
    write = write_gif if arguments.output.lower().endswith(".gif") else write_film
    write(frames(results, arguments), arguments.output, arguments.fps)
