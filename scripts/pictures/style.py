"""One look for all pictures: readable at the width of a paper's column, and by the colour-blind.

Colours of lines and materials are those of Okabe and Ito (2008); fields have viridis, or a diverging map about zero."""

import os

import matplotlib.pyplot as plt
import numpy as np
from PIL import Image
from cycler import cycler
from matplotlib import patheffects
from matplotlib.transforms import offset_copy

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#F0E442")
GROUND = ("#D9C9A3", "#B7C9D9", "#C5D6B0", "#E3BFA8", "#D4C2DC", "#EFE3A0", "#BFDAD6", "#CFCFCF")  # of materials, pale
SEQUENTIAL, DIVERGING = "viridis", "RdBu_r"
INK, SOFT, WATER, FIXED, LOAD, RIGID = "0.1", "0.6", "#0072B2", "0.25", "#B22222", "0.45"
WIDTH = 5.2  # inches: 8.5 pt here are 6 pt in a column of 9 cm
SMALL, TINY = 7.5, 5.0  # points: names within a picture, and within a small one
FILLED = 0.075  # of the height of small axes: a name
LABEL = 30.0  # points: numbers and label of the x axis
DPI, DPI_SHEET = 190, 120  # of one picture, and of a sheet of several, 10 to 12 inches wide
LARGE_FILE = 150e3  # bytes
HALO = [patheffects.withStroke(linewidth=1.8, foreground="white")]

SETTINGS = {
    "font.size": 8.5,
    "axes.titlesize": 8.5,
    "axes.labelsize": 8.5,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "figure.titlesize": 8.5,
    "axes.linewidth": 0.7,
    "lines.linewidth": 1.4,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "axes.prop_cycle": cycler(color=COLOURS),
    "savefig.dpi": DPI,
    "figure.dpi": 100,
    "image.cmap": SEQUENTIAL,
    "axes.titlelocation": "center",
    "mathtext.default": "it",
    "svg.hashsalt": "talus",
}


def apply():
    """Makes the look that of all figures from now on."""
    plt.rcParams.update(SETTINGS)


def settle(figure):
    """Lays a figure out once more: the first layout does not know how equal axes shrink, and may cut a label off."""
    figure.canvas.draw()


def save(figure, path, **options):
    """Writes a figure; a large PNG with a palette, which makes it a third as large."""
    png = str(path).lower().endswith(".png")
    figure.savefig(path, **options, **({"pil_kwargs": {"optimize": True}} if png else {}))
    if png and os.path.getsize(path) > LARGE_FILE:
        with Image.open(path) as whole:
            small = whole.convert("RGB").quantize(256, dither=Image.Dither.NONE)
        small.save(path, optimize=True)


def open_axes(axes):
    """Axes of curves: a light grid, no frame on the right and above."""
    axes.grid(alpha=0.3, linewidth=0.5)
    axes.spines[["top", "right"]].set_visible(False)
    return axes


def name(axes, x, y, text, **options):
    """A name within a picture, readable on every colour."""
    height = axes.get_window_extent().height * 72.0 / axes.figure.dpi if hasattr(axes, "get_window_extent") else np.inf
    size = float(np.clip(FILLED * height, TINY, SMALL))
    options = {"fontsize": size, "ha": "center", "va": "center", "color": INK, "zorder": 8, "clip_on": True, **options}
    return axes.text(x, y, text, path_effects=HALO, **options)


def legend_below(axes, handles):
    """A legend below the axes and their label."""
    below = offset_copy(axes.transAxes, axes.figure, y=-LABEL, units="points")
    axes.legend(
        handles=handles, loc="upper center", bbox_to_anchor=(0.5, 0.0), bbox_transform=below, ncols=min(len(handles), 5)
    )


def material_colour(number):
    return GROUND[number % len(GROUND)]
