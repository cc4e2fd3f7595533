"""What unused grid costs: the cantilever in a box four times as long on each axis, with the same cells."""
from bench import figures
from bench.runs import CANTILEVER, BenchmarkError, Table, in_turn, median, run_scene

BOXES = {"near": {}, "far": {"mpm_grid_upper": "60,60", "mpm_grid_cells": "240,240"}}
QUICK = {"near": {"mpm_grid_cells": "30,30"}, "far": {"mpm_grid_upper": "60,60", "mpm_grid_cells": "120,120"}}


def add_arguments(parser):
    parser.set_defaults(ranks=2)


def draw(runs, folder):
    figure, panels = figures.panels(2, width=4.0)
    for axes, entry, factor, name in ((panels[0], "time_total_s", 1.0, "seconds"),
                                      (panels[1], "memory_max_bytes", 1e-6, "memory (MB)")):
        for place, (box, mine) in enumerate(runs.items()):
            axes.plot([place] * len(mine), [run[entry] * factor for run in mine], "o", color=figures.COLOURS[place])
        axes.set_xticks(range(len(runs)), ["beam's box", "4 times as long"])
        figures.label(axes, "", "", name, log="")
        axes.set(xlim=(-0.5, 1.5), ylim=(0.0, None))
    figures.save(figure, folder, "box")


def run(arguments):
    boxes = QUICK if arguments.quick else BOXES
    table = Table(arguments.out, "box", ["ranks", "time_ratio", "memory_ratio"])
    repeat = arguments.repeat or (1 if arguments.quick else 3)
    runs = dict(zip(boxes, in_turn(repeat, [
        lambda options=options: run_scene(arguments.program, CANTILEVER, options, arguments.ranks)
        for options in boxes.values()])))
    for name, mine in runs.items():
        if not mine[0].completed:
            raise BenchmarkError(f"the run in the {name} box {mine[0].status}")
    near, far = runs["near"], runs["far"]
    table.add(ranks=arguments.ranks, time_ratio=median(far, "time_total_s") / median(near, "time_total_s"),
              memory_ratio=median(far, "memory_max_bytes") / median(near, "memory_max_bytes"))
    draw(runs, arguments.out)
