#!/usr/bin/env python3
"""Level clay: at rest, with its stress by weight and OCR; then the settlement under a wide load against the oedometer's, or under a
strip beside the sum of oedometers below it."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

REST = 1e-9  # movement over height
INCREMENTS = 1500  # of the reference, for the largest strain that it looks for
LARGEST = 0.12
LAYERS, PLACES = 200, 12


class Ground:
    """The clay and its state at rest by height, from the scene's options."""

    def __init__(self, results):
        def number(name):
            return results.numbers(name)[0]

        self.M, self.kappa, self.slope, self.G = (number(f"mpm_material_clay_{name}") for name in ("M", "kappa", "lambda", "G"))
        self.p_min = number("mpm_material_clay_pressure_min")
        self.gamma = -number("mpm_material_clay_density") * results.numbers("mpm_load_weight_value")[1]
        self.width, self.height = results.numbers("mpm_body_ground_upper")
        profile = results.option("mpm_body_ground_initial_preconsolidation")
        self.profile = np.array([[float(part) for part in pair.split(":")] for pair in profile.split(",")]).T
        self.load = -results.numbers("mpm_load_strip_value")[1]
        self.half = results.numbers("mpm_load_strip_upper")[0]
        self.wide = self.half == self.width

    def weight(self, y):
        return self.gamma * (self.height - y)

    def preconsolidation(self, y):
        return np.interp(y, *self.profile)

    def overconsolidation(self, y):
        """p_c over that with which the stress of Jaky's ratio would yield, and that ratio."""
        jaky, weight = 1.0 - 3.0 * self.M / (6.0 + self.M), self.weight(y)
        p, q = (1.0 + 2.0 * jaky) / 3.0 * weight, (1.0 - jaky) * weight
        return self.preconsolidation(y) / (p + (q / self.M) ** 2 / p), jaky

    def ratio(self, y):
        """Jaky's ratio times OCR^sin(phi)."""
        ocr, jaky = self.overconsolidation(y)
        return jaky * np.maximum(ocr, 1.0) ** (1.0 - jaky)

    def rate(self, p, q, size):
        """Of p, q and p_c by axial strain, nothing moving sideways; compression positive. The rate form of the law."""
        normal, side = 2.0 * p - size, 2.0 * q / self.M**2
        bulk = np.maximum(p, self.p_min) / self.kappa
        loading = normal * bulk + side * 2.0 * self.G
        yields = ((q / self.M) ** 2 + p * (p - size) >= 0.0) & (loading > 0.0)
        hardening = size / (self.slope - self.kappa)
        flow = np.where(yields, loading / (normal**2 * bulk + 3.0 * self.G * side**2 + p * hardening * normal), 0.0)
        return bulk * (1.0 - flow * normal), 2.0 * self.G - 3.0 * self.G * flow * side, hardening * flow * normal

    def strain(self, y, load):
        """Logarithmic axial strain of an oedometer at each height, by midpoint steps; the area stays: sigma = tau/J."""
        ratio, weight = self.ratio(y), self.weight(y)
        state = np.array([(1.0 + 2.0 * ratio) / 3.0 * weight, (1.0 - ratio) * weight, self.preconsolidation(y)])
        goal, before, found = weight + load, weight, np.full(y.shape, np.nan)
        step = LARGEST / INCREMENTS
        for k in range(INCREMENTS):
            middle = state + 0.5 * step * np.array(self.rate(*state))
            state = state + step * np.array(self.rate(*middle))
            after = (state[0] + 2.0 / 3.0 * state[1]) * np.exp((k + 1) * step)
            reached = np.isnan(found) & (after >= goal)
            found[reached] = ((k + (goal - before) / (after - before)) * step)[reached]
            before = after
        return found

    def layers(self):
        """Middles of thin layers."""
        return (np.arange(LAYERS) + 0.5) * self.height / LAYERS

    def settlement(self, y):
        """By height under a wide load: what lies below each y has lost."""
        middle = self.layers()
        lost = np.cumsum(1.0 - np.exp(-self.strain(middle, np.full(LAYERS, self.load)))) * self.height / LAYERS
        return np.interp(y, np.linspace(0.0, self.height, LAYERS + 1), np.concatenate([[0.0], lost]))

    def strip_settlement(self):
        """The mean under the strip, and its middle's, of the sums of oedometers under Boussinesq's vertical stress in a half-space."""
        x = np.concatenate([[0.0], self.half * (np.arange(PLACES) + 0.5) / PLACES])
        x, y = (part.ravel() for part in np.meshgrid(x, self.layers(), indexing="ij"))
        left, right = (np.arctan((x + sign * self.half) / (self.height - y)) for sign in (1.0, -1.0))
        angle = left - right
        strain = self.strain(y, self.load / np.pi * (angle + np.sin(angle) * np.cos(left + right)))
        sums = (1.0 - np.exp(-strain)).reshape(-1, LAYERS).mean(axis=1) * self.height
        return sums[1:].mean(), sums[0]


def at_rest(results, ground):
    """The stage after the geostatic one."""
    hold = int(np.flatnonzero(results.column("stage") == 2)[-1]) + 1
    state = results.state(hold)
    y, stress = state["position"][:, 1], state["stress"]
    ratio = stress[:, [0, 2]] / stress[:, 1:2] / ground.ratio(y)[:, None]
    reach = None if "bspline" in results.option("mpm_shape") else 1e-9  # what balances the weight is not its integral there
    return [Quantity("moved_over_height", np.linalg.norm(state["displacement"], axis=1).max() / ground.height, upper=REST),
            Quantity("weight_error", np.abs(-stress[:, 1] / ground.weight(y) - 1.0).max(), upper=reach),
            Quantity("ratio_error", np.abs(ratio - 1.0).max(), upper=1e-9),
            Quantity("preconsolidation_error", np.abs(state["preconsolidation"] / ground.preconsolidation(y) - 1.0).max(), upper=1e-12)]


def top_row(results, ground):
    """Points of the uppermost row under the load."""
    position = results.initial["position0"]
    return (position[:, 1] > position[:, 1].max() - 1e-6) & (position[:, 0] < ground.half)


def check(results):
    ground, last = Ground(results), results.state("last")
    total = ground.gamma * ground.width * ground.height + ground.load * ground.half
    lowered = -last["displacement"][:, 1]
    quantities = [common.completed(results), *at_rest(results, ground),
                  Quantity("reaction_error", abs(results.column("reaction_base_y")[-1] / total - 1.0), upper=1e-8),
                  Quantity("settlement", lowered[top_row(results, ground)].mean())]
    if ground.wide:
        y = np.unique(results.initial["position0"][:, 1].round(9))
        expected = ground.settlement(np.append(y, ground.height))
        error = np.abs(lowered - np.interp(results.initial["position0"][:, 1], y, expected[:-1])).max() / expected[-1]
        return quantities + [Quantity("settlement_of_the_surface_expected", expected[-1]),
                             Quantity("settlement_error", error, upper=0.005)]
    mean, _ = ground.strip_settlement()
    return quantities + [Quantity("settlement_over_sum_of_oedometers", lowered[top_row(results, ground)].mean() / mean, 0.9, 1.1)]


def draw_rest(axes, results, ground):
    y = np.linspace(0.0, ground.height - 1e-3, 200)
    state = results.state(1)
    points = np.argsort(state["position"][:, 1])[:: max(1, len(state["position"]) // 40)]
    axes[0].plot(ground.weight(y) / 1e3, y, label="vertical stress")
    axes[0].plot(ground.weight(y) * ground.ratio(y) / 1e3, y, label="horizontal")
    axes[0].plot(ground.preconsolidation(y) / 1e3, y, label="$p_c$")
    for column, color in ((1, "C0"), (0, "C1")):
        axes[0].plot(-state["stress"][points, column] / 1e3, state["position"][points, 1], "o", color=color, markersize=4,
                     markerfacecolor="white")
    axes[0].set(xlabel="kPa", ylabel="height (m)", title="at rest", xlim=(0.0, 330.0))
    axes[0].legend(fontsize="small", loc="upper right")
    axes[1].semilogx(ground.overconsolidation(y)[0], y, color="C2")
    axes[1].set(xlabel="OCR", xlim=(0.9, 100.0))


def draw(results):
    import matplotlib.pyplot as plt

    ground, last = Ground(results), results.state("last")
    figure = plt.figure(figsize=(9.5, 6.6), layout="constrained")
    grid = figure.add_gridspec(2, 10, height_ratios=(1.2, 1))
    axes = [figure.add_subplot(place) for place in (grid[0, :4], grid[0, 4:6], grid[0, 6:], grid[1, :])]
    draw_rest(axes[:2], results, ground)
    rows = results.column("stage") == 3
    pressure = ground.load / 1e3 * (results.column("time")[rows] - results.column("time")[~rows][-1])
    axes[2].plot(-1e3 * results.column("track_strip_uy")[rows], pressure, label="Talus, mean under the load")
    if ground.wide:
        surface = ground.settlement(ground.height)
        axes[2].plot(1e3 * surface, ground.load / 1e3, "s", label="oedometers")
    else:
        axes[2].plot(1e3 * ground.strip_settlement()[0], ground.load / 1e3, "s", label="sums of oedometers")
    axes[2].set(xlabel="settlement (mm)", ylabel="load (kPa)", title="settlement")
    axes[2].legend(frameon=False, fontsize="small")
    growth = last["preconsolidation"] / ground.preconsolidation(results.initial["position0"][:, 1])
    dots = axes[3].scatter(*last["position"].T, c=growth, s=5.0 if ground.width > 5.0 else 30.0, marker="s", linewidths=0.0)
    figure.colorbar(dots, ax=axes[3], label="$p_c$ over that at rest")
    axes[3].set(aspect="equal", xlabel="x (m)", ylabel="height (m)", title="where the clay yields")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
