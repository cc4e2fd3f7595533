#!/usr/bin/env python3
"""Numbers of some runs against those in scalars.csv, which were computed with Talus itself: they guard against change.

A row of the table: the scene (below the repository), further options, a column of the history, the time, the value, and
how near a run has to come, relatively and absolutely. --update writes the values of this program into the table.

Quick.
"""
import csv
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ROOT, Test  # noqa: E402

TABLE = Path(__file__).resolve().parent / "scalars.csv"


def read_rows():
    with open(TABLE, encoding="utf-8") as file:
        remarks, lines = [], []
        for line in file:
            (remarks if line.startswith("#") else lines).append(line)
    return remarks, list(csv.DictReader(lines))


def value_at(run, row):
    step = np.flatnonzero(np.isclose(run.results.column("time"), float(row["time"])))
    return run.results.column(row["column"])[step[0]] if step.size else np.nan


def options_of(row):
    """name=value pairs, separated by blanks."""
    return dict(pair.split("=", 1) for pair in row["options"].split())


update = "--update" in sys.argv
if update:
    sys.argv.remove("--update")
with Test() as test:
    head, rows = read_rows()
    runs = {}
    for row in rows:
        key = (row["scene"], row["options"])
        if key not in runs:
            runs[key] = test.run(ROOT / row["scene"], mpm_quiet=None, mpm_output_every=0, **options_of(row))
        value = value_at(runs[key], row)
        if update:
            row["value"] = f"{value:.10g}"
            test.count += 1
        else:
            scene = Path(row["scene"])
            name = scene.parent.name if scene.stem == "case" else scene.stem
            label = ".".join([name, *row["options"].split(), f"{row['column']}_at_{row['time']}"])
            test.near(label, value, float(row["value"]), float(row["rtol"]), float(row["atol"]))
    if update:
        with open(TABLE, "w", encoding="utf-8") as table:
            table.writelines(head)
            writer = csv.DictWriter(table, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
