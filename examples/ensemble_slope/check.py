#!/usr/bin/env python3
"""Compares the factors of safety of an ensemble with the distribution that follows from those of strength and weight."""
import math
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

GRAVITY, HEIGHT = 10.0, 10.0  # m/s2, m
COHESION, DENSITY = (60e3, 12e3), (2000.0, 100.0)  # mean and standard deviation: Pa, kg/m3
TAYLOR = 5.88  # F gamma H/c of a slope of 2:1 over a deep foundation


def members(results):
    """Draws and factors of the members that were completed; F gamma H/c of each."""
    table = common.read_table(f"{results.prefix}_members.csv")
    table = {name: values[table["status"] == 0] for name, values in table.items()}
    return table, table["factor_of_safety"] * table["density"] * GRAVITY * HEIGHT / table["cohesion"]


def over_weights(values):
    """Mean over the normal distribution of the weight, gamma H, of a function of it."""
    points, weights = np.polynomial.hermite_e.hermegauss(20)
    return float(np.dot(weights, values((DENSITY[0] + DENSITY[1] * points) * GRAVITY * HEIGHT)) / weights.sum())


def below(factor, number):
    """Probability of a factor of safety below `factor`: that of a lognormal strength below the one that has it."""
    deviation = math.sqrt(math.log(1.0 + (COHESION[1] / COHESION[0]) ** 2))
    mean = math.log(COHESION[0]) - 0.5 * deviation ** 2
    z = lambda weight: (mean - np.log(factor * weight / number)) / (deviation * math.sqrt(2.0))  # noqa: E731
    return over_weights(lambda weight: [0.5 * math.erfc(value) for value in z(weight)])


def distance(table, number):
    """Largest distance of the members' distribution from that of the closed form (Kolmogorov and Smirnov)."""
    factors = np.sort(table["factor_of_safety"])
    exact = np.array([below(factor, number) for factor in factors])
    steps = np.arange(len(factors) + 1) / len(factors)
    return float(max(np.max(exact - steps[:-1]), np.max(steps[1:] - exact)))


def check(results):
    table, numbers = members(results)
    summary = results.summary
    return [common.completed(results), Quantity("members", summary["completed"], summary["members"], summary["members"]),
            Quantity.near("stability_number", numbers.mean(), TAYLOR, relative=0.05),
            Quantity("spread", numbers.std() / numbers.mean(), 0.0, 2e-3),
            Quantity.near("mean", table["factor_of_safety"].mean(), numbers.mean() * COHESION[0] * over_weights(lambda weight: 1.0 / weight),
                          relative=0.5 / len(numbers)),
            Quantity("distance", distance(table, numbers.mean()), 0.0, 1.36 / math.sqrt(len(numbers)))]


def draw(results):
    """Factor of safety over strength, and its distribution beside the closed form."""
    import matplotlib.pyplot as plt

    table, numbers = members(results)
    factors = np.sort(table["factor_of_safety"])
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 4.0), layout="constrained")
    places = left.scatter(1e-3 * table["cohesion"], table["factor_of_safety"], c=table["density"], cmap="viridis")
    figure.colorbar(places, ax=left, label="density (kg/m3)")
    left.set(xlabel="undrained strength (kPa)", ylabel="factor of safety")
    curve = np.linspace(0.8 * factors[0], 1.1 * factors[-1], 200)
    right.plot(curve, [below(factor, numbers.mean()) for factor in curve], color="0.4", label="closed form")
    right.step(factors, np.arange(1, len(factors) + 1) / len(factors), where="post", color="tab:blue",
               label=f"{len(factors)} members")
    right.set(xlabel="factor of safety", ylabel="probability of less", ylim=(0.0, 1.02))
    right.legend(loc="lower right")
    for axes in (left, right):
        axes.grid(alpha=0.3)
    return figure


if __name__ == "__main__":
    common.main(check, draw)
