#!/usr/bin/env python3
"""Benchmarks of Talus: medians of several runs, as CSV on the terminal and, with pictures, in a folder.

    scripts/bench.py SUBCOMMAND --help
    scripts/bench.py SUBCOMMAND --quick     # small and short: does it work?

Run it on a machine that does nothing else.
"""
import argparse
import importlib
import pkgutil
import sys
from pathlib import Path

import bench
from bench.runs import ROOT, BenchmarkError


def subcommands():
    """Modules of the package by the name of their subcommand; one whose imports are missing is left out."""
    found = {}
    for entry in pkgutil.iter_modules(bench.__path__):
        try:
            module = importlib.import_module(f"bench.{entry.name}")
        except ImportError as error:
            print(f"bench.py: {entry.name} is left out: {error}", file=sys.stderr)
            continue
        if hasattr(module, "add_arguments") and hasattr(module, "run"):
            found[getattr(module, "NAME", entry.name.replace("_", "-"))] = module
    return found


def common_arguments(parser):
    parser.add_argument("--program", default=str(ROOT / "build" / "talus"), help="what is measured (build/talus)")
    parser.add_argument("--ranks", type=int, default=None, metavar="N", help="MPI ranks of a run")
    parser.add_argument("--repeat", type=int, default=None, metavar="N", help="runs that a median is taken of")
    parser.add_argument("--quick", action="store_true", help="a short version on small grids")
    parser.add_argument("--out", type=Path, default=Path("out/bench"), metavar="FOLDER",
                        help="where CSV files and pictures go (out/bench)")


def parse(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    subparsers = parser.add_subparsers(title="subcommands", metavar="SUBCOMMAND", required=True)
    for name, module in subcommands().items():
        text = (module.__doc__ or name).strip()
        subparser = subparsers.add_parser(name, help=text.splitlines()[0].rstrip("."), description=text,
                                          formatter_class=argparse.RawDescriptionHelpFormatter,
                                          conflict_handler="resolve")  # a module may have its own idea of --ranks
        common_arguments(subparser)
        module.add_arguments(subparser)
        subparser.set_defaults(function=module.run)
    return parser.parse_args(words)


def main(words=None):
    arguments = parse(words)
    try:
        return arguments.function(arguments) or 0
    except (BenchmarkError, OSError) as error:
        print(f"bench.py: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
