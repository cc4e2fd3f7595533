"""The command line of pictures: `talus plot`, `talus view`, `talus check --picture`, or scripts/plot.py."""

import argparse
import os
import sys
from pathlib import Path

import matplotlib

if "--live" not in sys.argv or not os.environ.get("DISPLAY"):
    matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of the screen)

from results import Results, ResultsError  # noqa: E402

from . import style  # noqa: E402
from .curves import plot_history  # noqa: E402
from .film import make_film, watch  # noqa: E402
from .ground import plot_scene  # noqa: E402
from .laboratory import is_laboratory, plot_laboratory  # noqa: E402
from .lines import plot_line  # noqa: E402
from .scene import Scene  # noqa: E402
from .states import plot_multiples, plot_state  # noqa: E402
from .terrain import film_terrain, plot_terrain  # noqa: E402

DESCRIPTION = """Draws the results of a run: the material coloured by a field, as a picture, several or a film, curves of
the history, forces along a row of cuts, stress along a line, or a laboratory test."""
EXAMPLES = """examples:
  talus plot out/cantilever                                            displacement at the last written step
  talus plot out/cantilever --field stress --component xx --output stress.png
  talus plot out/slope --field equivalent_plastic_strain --steps 6     six states beside each other
  talus plot out/slope --film --output slope.gif                       all written states, moving
  talus plot out/slope --history track_crest_uy reduction              two columns over time
  talus plot out/wall --section wall                                   N, V and M beside the wall
  talus plot out/wall --profile base --step first
  talus plot out/slump3d --slice z=0.5 --field pressure                a slice through a body in space
  talus plot out/triaxial --measured data.csv                          a laboratory test (physics stress_point)

derived fields: von_mises and pressure (from stress), the magnitude of vectors (no --component), material, body."""


def add_field(parser):
    parser.add_argument("prefix", help="what the names of the result files start with, like out/cantilever")
    parser.add_argument("--field", default="displacement", help="what the material is coloured by (displacement)")
    parser.add_argument("--component", help="xx, yy, zz, xy, yz, xz of a tensor; x, y, z of a vector")
    parser.add_argument("--step", default="last", help="first, last, or the number of a written step (last)")
    parser.add_argument(
        "--limits",
        nargs=2,
        type=float,
        metavar=("LOW", "HIGH"),
        help="ends of the colour bar, in its unit (the extremes)",
    )
    parser.add_argument("--colours", metavar="MAP", help="a colour map of matplotlib (viridis, or RdBu_r about zero)")


def plot_parser(program):
    parser = argparse.ArgumentParser(
        prog=program, description=DESCRIPTION, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add_field(parser)
    parser.add_argument(
        "--scale", type=float, default=1.0, metavar="FACTOR", help="displacements are drawn so many times larger (1)"
    )
    parser.add_argument("--initial", action="store_true", help="draw the material where it was at first")
    parser.add_argument("--deformed", action="store_true", help="draw it where it is at that step (the default)")
    parser.add_argument(
        "--arrows", nargs="?", const="displacement", metavar="FIELD", help="arrows of a vector field (displacement)"
    )
    parser.add_argument("--contours", nargs="?", const=8, type=int, metavar="NUMBER", help="contour lines (8)")
    parser.add_argument("--plain", action="store_true", help="without names, conditions, loads, boundaries and water")
    parser.add_argument("--slice", metavar="AXIS=PLACE", help="of a body in space what this plane cuts, as z=0.5")
    parser.add_argument(
        "--steps", nargs="+", metavar="STEP", help="several states beside each other: so many, or these steps"
    )
    parser.add_argument(
        "--film", "--animate", action="store_true", help="all written states as a film (.gif; .mp4 with ffmpeg)"
    )
    parser.add_argument("--fps", type=float, default=8.0, help="pictures a second of a film (8)")
    parser.add_argument("--live", action="store_true", help="while the run goes on, draw each new state, until it ends")
    parser.add_argument(
        "--history", nargs="+", metavar="COLUMN", help="draw columns of the history instead of the material"
    )
    parser.add_argument("--x", default="time", metavar="COLUMN", help="the column along the x axis (time)")
    parser.add_argument(
        "--since-reset", action="store_true", help="displacement of tracks since the last reset, not in total"
    )
    parser.add_argument("--section", metavar="NAME", help="draw N, V and M along a row of cuts at --step")
    parser.add_argument("--profile", metavar="NAME", help="draw normal and shear stress along a line at --step")
    parser.add_argument(
        "--measured",
        metavar="FILE.csv",
        help="measurements beside a laboratory test: columns strain_yy, p, q, eps_v, e, signs as in the history",
    )
    parser.add_argument(
        "--scene",
        action="store_true",
        help="draw the scene in its first state: grid, bodies by material, all that acts",
    )
    parser.add_argument(
        "--terrain",
        action="store_true",
        help="draw maps of a flow over terrain: its largest values, or those at --step, on the bed",
    )
    parser.add_argument("--title", help="the picture's title (the scene's)")
    parser.add_argument("--output", help="file; its ending tells the format (plot.png, or plot.gif of a film)")
    return parser


def view_parser():
    parser = argparse.ArgumentParser(
        prog="talus view", description="Shows the results of a run in a window (by pyvista), with a slider over steps."
    )
    add_field(parser)
    parser.add_argument("--screenshot", metavar="FILE.png", help="write a picture instead of opening a window")
    return parser


def draw(results, scene, arguments):
    """The figure that the arguments ask for."""
    if arguments.history:
        return plot_history(results, scene, arguments)
    for kind in ("section", "profile"):
        if getattr(arguments, kind):
            return plot_line(results, scene, kind, getattr(arguments, kind), arguments)
    if arguments.measured and not is_laboratory(results):
        raise ResultsError("--measured: measurements go with a laboratory test, physics stress_point")
    if arguments.terrain:
        return plot_terrain(results, scene, arguments)
    if arguments.scene:
        return plot_scene(results, scene, arguments)
    if is_laboratory(results):
        return plot_laboratory(results, arguments.measured, arguments.title)
    return plot_multiples(results, scene, arguments) if arguments.steps else plot_state(results, scene, arguments)


def save(figure, path):
    """Writes a figure, and forgets it."""
    style.settle(figure)
    style.save(figure, path)
    plt.close(figure)


def make(arguments):
    if arguments.colours and arguments.colours not in plt.colormaps():
        raise ResultsError(f"matplotlib has no colour map '{arguments.colours}'")
    results = Results(arguments.prefix)
    if arguments.live:
        watch(lambda: Results(arguments.prefix), arguments, lambda now: draw(now, Scene(now), arguments))
    elif arguments.film and arguments.terrain:
        film_terrain(results, arguments)
    elif arguments.film:
        make_film(results, Scene(results), arguments)
    else:
        save(draw(results, Scene(results), arguments), arguments.output)


def main(words=None, program="plot.py"):
    """Reads the words of the command line; the exit status."""
    words = sys.argv[1:] if words is None else words
    style.apply()
    showing = program.endswith("view")
    parser = view_parser() if showing else plot_parser(program)
    arguments = parser.parse_args(words)
    try:
        if showing:
            from .view import view

            results = Results(arguments.prefix)
            view(results, Scene(results), arguments)
            return 0
        arguments.output = arguments.output or ("plot.gif" if arguments.film else "plot.png")
        Path(arguments.output).parent.mkdir(parents=True, exist_ok=True)
        make(arguments)
    except (ResultsError, OSError, ValueError) as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return 2
    print(arguments.output)
    return 0
