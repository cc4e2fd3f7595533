"""Films of the written states, and pictures of a run that goes on.

One figure serves all frames: only the domains, their colours and the outlines change from frame to frame."""

import shutil
import subprocess
import time

import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

from results import ResultsError

from . import style
from .plane import bar
from .states import common, draw_state, figure_size, new_axes, title_of

PERCENTILE = 1.0  # of all numbers of a film lie beyond either end of its colour bar
FRAMES = 150  # at most, spread evenly over the states
FRAME_DPI = 110
PATIENCE = 0.5  # s between two looks at a run that goes on


def pixels(figure):
    figure.canvas.draw()
    return np.asarray(figure.canvas.buffer_rgba())[:, :, :3].copy()


def wipe(axes):
    """Takes all that was drawn from the axes, but not their ticks, which take longer than a frame."""
    for artist in [*axes.collections, *axes.patches, *axes.lines, *axes.texts, *axes.artists]:
        artist.remove()


def frames(results, scene, arguments):
    """The pictures of a film, one after the other."""
    steps = results.steps
    steps = [steps[k] for k in np.unique(np.linspace(0, len(steps) - 1, min(len(steps), FRAMES)).round().astype(int))]
    states, series = common(results, scene, steps, arguments, PERCENTILE)
    flat = len(series[2][0]) == 2
    figure = plt.figure(figsize=figure_size(series[2]), dpi=FRAME_DPI, layout="constrained")
    axes, label = new_axes(figure, flat), None
    for state in states:
        wipe(axes)
        scale, text = draw_state(figure, axes, results, scene, state, arguments, series)
        title = figure.suptitle(title_of(scene, state, arguments))
        if label is None and scale:
            bar(figure, axes, scale, text, extend="both" if not arguments.limits else "neither")
            label = text
        if state is states[0]:
            style.settle(figure)
        yield pixels(figure)
        figure.set_layout_engine("none")  # one layout for all
        title.set_text("")


def make_film(results, scene, arguments):
    """Writes the written states as a film: the same colours, limits and axes throughout."""
    if arguments.output.lower().endswith(".gif"):
        write_gif(frames(results, scene, arguments), arguments.output, arguments.fps)
    elif shutil.which("ffmpeg"):
        write_film(frames(results, scene, arguments), arguments.output, arguments.fps)
    else:
        raise ResultsError(f"{arguments.output}: ffmpeg is not installed; without it, films are .gif")


def write_gif(pictures, path, fps):
    """One palette for all pictures, that of the last, which has the most colours; the last one stands for longer."""
    pictures = [Image.fromarray(picture) for picture in pictures]
    palette = Image.fromarray(np.concatenate([np.asarray(pictures[k]) for k in (0, len(pictures) // 2, -1)])).quantize(
        128
    )
    images = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    duration = [round(1000.0 / fps)] * (len(images) - 1) + [round(1000.0 / fps) + 1000]
    images[0].save(path, save_all=True, append_images=images[1:], duration=duration, loop=0)


def write_film(pictures, path, fps):
    """A film by ffmpeg, of frames of even width and height."""
    encoder = None
    for picture in pictures:
        height, width = (2 * (size // 2) for size in picture.shape[:2])
        if encoder is None:
            command = [
                "ffmpeg",
                "-loglevel",
                "error",
                "-y",
                "-f",
                "rawvideo",
                "-pix_fmt",
                "rgb24",
                "-s",
                f"{width}x{height}",
                "-r",
                str(fps),
                "-i",
                "-",
                "-pix_fmt",
                "yuv420p",
                path,
            ]
            encoder = subprocess.Popen(command, stdin=subprocess.PIPE)
        encoder.stdin.write(np.ascontiguousarray(picture[:height, :width]).tobytes())
    encoder.stdin.close()
    if encoder.wait():
        raise ResultsError(f"{path}: ffmpeg could not write it")


def ended(results):
    """True where the run has ended: its summary is newer than its last state."""
    try:
        return results.path("_summary.json").stat().st_mtime >= results.path("_history.csv").stat().st_mtime
    except ResultsError:
        return False


def redraw(results, arguments, draw):
    """Writes a figure of the last state, and shows it on a screen; False while the state is being written."""
    try:
        figure = draw(results)
    except (OSError, KeyError, ResultsError):
        return False
    style.settle(figure)
    figure.savefig(arguments.output)
    if plt.get_backend().lower() == "agg":
        plt.close(figure)
    else:
        plt.pause(0.01)
        for number in plt.get_fignums():
            if plt.figure(number) is not figure:
                plt.close(number)
    return True


def watch(make, arguments, draw):
    """Draws each new state until the run has ended. `make` gives fresh results, `draw` a figure of them."""
    seen = None
    while True:
        results = make()
        done = ended(results)
        try:
            last = results.steps[-1:]
        except (OSError, ResultsError):  # not begun, or being written
            last = []
        if last and last[0] != seen and redraw(results, arguments, draw):
            seen = last[0]
            print(f"step {seen}", flush=True)
        if done:
            return
        time.sleep(PATIENCE)
