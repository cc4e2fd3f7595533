"""What the checks of the examples share: reading results, printing quantities beside their bounds, the command line."""
import argparse
import csv
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "scripts"))
from results import Results, ResultsError  # noqa: E402  (the folder has to be known first)


class Quantity:
    """A number and the range it has to be in; either end may be open (None)."""

    def __init__(self, name, value, lower=None, upper=None):
        self.name, self.value, self.lower, self.upper = name, float(value), lower, upper

    @classmethod
    def near(cls, name, value, reference, relative=0.0, absolute=0.0):
        reach = abs(reference) * relative + absolute
        return cls(name, value, reference - reach, reference + reach)

    @property
    def good(self):
        return not (np.isnan(self.value) or (self.lower is not None and self.value < self.lower)
                    or (self.upper is not None and self.value > self.upper))

    @property
    def bound(self):
        if self.lower is None:
            return "none" if self.upper is None else f"<={self.upper:.6g}"
        return f">={self.lower:.6g}" if self.upper is None else f"[{self.lower:.6g},{self.upper:.6g}]"

    def __str__(self):
        return f"{self.name} {self.value:.6g} {self.bound}"


def completed(results):
    """The quantity that every check starts with: 1 when the run ended as it should."""
    return Quantity("completed", results.summary["status"] == "completed", 1.0)


def read_table(path):
    """Columns of a CSV file by name, as numbers; lines that start with # are remarks."""
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def cells(results):
    """Cells per axis, refinement included."""
    refine = int(results.option("mpm_grid_refine", "1"))
    return [int(count) * refine for count in results.numbers("mpm_grid_cells")]


def same_settings(results, settings):
    """Was the run made with these settings? Numbers are compared as numbers, other options as text."""

    def parts(text):
        try:
            return [float(part) for part in text.split(",")]
        except ValueError:
            return text.strip()

    return all(parts(results.option(name, "")) == parts(value) for name, value in settings.items())


def outline(place):
    """The points of a convex body that bound it, once round (Andrew's monotone chain; those on a straight side are among them)."""
    reach = 1e-9 * np.ptp(place, axis=0).prod()

    def chain(order):
        way = []
        for point in order:
            while len(way) > 1 and np.cross(place[way[-1]] - place[way[-2]], place[point] - place[way[-1]]) < -reach:
                way.pop()
            way.append(point)
        return way[:-1]

    order = np.lexsort((place[:, 1], place[:, 0]))
    return np.array(chain(order) + chain(order[::-1]))


def main(check, draw):
    """The command line of a check: check(results) gives quantities, draw(results) a figure."""
    parser = argparse.ArgumentParser(description=sys.modules["__main__"].__doc__)
    parser.add_argument("prefix", help="what the names of the run's result files start with")
    parser.add_argument("--plot", metavar="FILE.png", help="draw the result beside theory")
    arguments = parser.parse_args()
    results = Results(arguments.prefix)
    try:
        quantities = check(results)
        for quantity in quantities:
            print(quantity)
        if arguments.plot:
            from pictures import style  # matplotlib takes a while to load, which checks alone need not

            style.apply()
            style.save(draw(results), arguments.plot, dpi=style.DPI_SHEET, bbox_inches="tight")
    except (ResultsError, OSError) as error:
        print(f"check.py: {error}", file=sys.stderr)
        sys.exit(2)
    outside = [quantity.name for quantity in quantities if not quantity.good]
    if outside:
        print(f"check.py: out of bounds: {', '.join(outside)}", file=sys.stderr)
        sys.exit(1)
