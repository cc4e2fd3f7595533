"""Microseconds a point of every constitutive law, as stress and as tangent, over those of j2 in the same run.

The program bench_materials evaluates the solid's kernel with each law at points of its own: increments from a state of 100
kPa of pressure, elastic and plastic ones, in plane strain and in 3D. Laws come from the registry, their parameters from
their tables: `default` has the typical values of what must be given and defaults besides, `typical` typical values of all.
An elastic law is compared with elastic j2.

bench_materials_twice is the same program with laws that solve their local problem (implicit.h) twice, in 3D: what that
takes longer is the local problem's share.
"""
import math
import statistics
from collections import defaultdict
from pathlib import Path

from bench import figures
from bench.runs import BenchmarkError, Table, check_program, execute, words_of

REFERENCE = "j2"
KEYS = ("law", "parameters", "dim", "state", "form")
LEAST_SHARE = 0.03  # less than that is noise


def add_arguments(parser):
    parser.set_defaults(ranks=1)
    parser.add_argument("--rounds", type=int, metavar="N", help="times that a run measures each case, of which the least counts (10; quick 2)")
    parser.add_argument("--sample", type=float, metavar="S", help="seconds of each time (1e-3; quick 2e-4)")
    parser.add_argument("--helper", metavar="PROGRAM", help="the program bench_materials (beside --program)")


def measure(program, arguments, dims):
    """Nanoseconds by keys, the least of a run's rounds, and the laws that solve their local problem twice."""
    options = {"bench_rounds": arguments.rounds, "bench_sample": arguments.sample, "bench_dims": dims}
    status, output, errors = execute([program] + words_of(options))
    if status != 0:
        raise BenchmarkError(f"{program}: exit status {status}\n{errors.strip()}")
    lines = [line.split() for line in output.splitlines()]
    local = [law for words in lines if words[0] == "local" for law in words[1:]]
    least = {}
    for *keys, nanoseconds in (words for words in lines if len(words) == len(KEYS) + 1):
        least[tuple(keys)] = min(float(nanoseconds), least.get(tuple(keys), math.inf))
    return least, local


def medians(arguments):
    """Nanoseconds by keys, of the program and of that whose local problems are solved twice, and the laws that have one."""
    programs = [(arguments.helper, "2,3")]
    twice = arguments.helper + "_twice"
    if Path(twice).exists():
        programs.append((twice, "3"))
    samples, local = [defaultdict(list), defaultdict(list)], []
    for _ in range(arguments.repeat):
        for (program, dims), mine in zip(programs, samples):
            least, local = measure(program, arguments, dims)
            for keys, nanoseconds in least.items():
                mine[keys].append(nanoseconds)
    once, twice = ({keys: statistics.median(values) for keys, values in mine.items()} for mine in samples)
    return once, twice, local


def reference(keys):
    """The case that another one is compared with."""
    return (REFERENCE, "default", *keys[2:])


def share(keys, once, twice):
    """The part of a step that solves the local problem; each program's times are taken over its own of the reference."""
    if keys not in twice or keys[3] != "plastic":
        return None
    part = (twice[keys] / twice[reference(keys)]) / (once[keys] / once[reference(keys)]) - 1.0
    return part if part > LEAST_SHARE else None


def draw(arguments, table):
    figure, axes = figures.panels(2, width=6.4, height=5.2)
    for panel, state in zip(axes, ("elastic", "plastic")):
        rows = [row for row in table.rows if row["state"] == state and row["form"] == "tangent" and row["dim"] == 3]
        rows.sort(key=lambda row: row["over_j2"])
        names = [row["law"] + (", all parameters" if row["parameters"] == "typical" else "") for row in rows]
        panel.barh(names, [row["over_j2"] for row in rows], color=figures.COLOURS[0])
        panel.axvline(1.0, color="0.3", linewidth=0.8)
        figures.label(panel, f"tangent in 3D, {state}", "time over that of j2", "", log="")
    figures.save(figure, arguments.out, "materials")


def run(arguments):
    quick = arguments.quick
    arguments.repeat = arguments.repeat or (1 if quick else 5)
    arguments.rounds = arguments.rounds or (2 if quick else 10)
    arguments.sample = arguments.sample or (2e-4 if quick else 1e-3)
    arguments.helper = arguments.helper or str(Path(arguments.program).parent / "bench_materials")
    check_program(arguments.helper)
    once, twice, local = medians(arguments)
    table = Table(arguments.out, "materials", [*KEYS, "us", "over_j2", "local_share"])
    for keys, nanoseconds in once.items():
        law, parameters, dim, state, form = keys
        table.add(law=law, parameters=parameters, dim=int(dim), state=state, form=form, us=1e-3 * nanoseconds,
                  over_j2=nanoseconds / once[reference(keys)],
                  local_share=share(keys, once, twice) if law in local else None)
    draw(arguments, table)
    return 0
