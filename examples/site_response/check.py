#!/usr/bin/env python3
"""Compares the amplification of a shaking soil layer with the transfer function of the damped column."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

PEAKS = 3
FREQUENCY, HEIGHT = 0.02, 0.05  # relative


class Column:
    """Layers from the top down: thickness, density, shear modulus; Rayleigh's damping; and what they stand on."""

    def __init__(self, results):
        self.mass, self.stiffness = (float(results.option(f"mpm_time_damping_{name}", "0")) for name in ("mass", "stiffness"))
        self.layers = []
        for body in results.option("mpm_bodies").split(","):
            lower, upper = (results.numbers(f"mpm_body_{body}_{side}")[1] for side in ("lower", "upper"))
            E, nu, density = (results.numbers(f"mpm_material_{body}_{name}")[0] for name in ("E", "nu", "density"))
            self.layers.append((upper - lower, density, 0.5 * E / (1.0 + nu)))
        self.layers.sort(key=lambda layer: layer[2])  # soft ones on top
        self.absorbing = results.option("mpm_bc_base_absorbing", "false") == "true"

    def transfer(self, frequency):
        """Velocity of the surface over that of the base, or over that of the wave that comes in."""
        w = 2.0 * np.pi * np.asarray(frequency)
        velocity, stress = np.ones_like(w, dtype=complex), np.zeros_like(w, dtype=complex)
        for thickness, density, shear in self.layers:  # down from the surface, where the velocity is 1
            modulus, inertia = shear * (1.0 + 1j * w * self.stiffness), density * (w**2 - 1j * w * self.mass)
            k = np.sqrt(inertia / modulus)
            ratio = modulus * k / (1j * w)  # stress over velocity
            cosine, sine = np.cos(k * thickness), np.sin(k * thickness)
            velocity, stress = velocity * cosine - stress / ratio * sine, stress * cosine + velocity * ratio * sine
        if self.absorbing:  # stress = rho c (2 v_in - v), downwards
            _, density, shear = self.layers[-1]
            velocity = 0.5 * (velocity - stress / np.sqrt(density * shear))
        return 1.0 / np.abs(velocity)


def spectrum(time, value, frequency):
    return np.abs(np.exp(-2j * np.pi * np.outer(frequency, time)) @ value)


def amplification(results, frequency):
    """From the surface's velocity and the triangle of the base's, value times its area times sinc^2."""
    time, velocity = results.column("time"), results.column("track_surface_vx")
    half, value = 0.05, results.numbers("mpm_bc_base_value")[0]
    base = value * half * np.sinc(frequency * half) ** 2
    return spectrum(time, velocity, frequency) * (time[1] - time[0]) / base


def peaks(frequency, height):
    """Frequency and height of the first maxima, each the largest within 0.4 Hz of it."""
    reach = round(0.4 / (frequency[1] - frequency[0]))
    at = [k for k in range(reach, len(height) - reach) if height[k] == np.max(height[k - reach:k + reach + 1])]
    return [(frequency[k], height[k]) for k in at[:PEAKS]]


def check(results):
    column, frequency = Column(results), np.arange(0.2, 8.0, 0.005)
    theory, found = peaks(frequency, column.transfer(frequency)), peaks(frequency, amplification(results, frequency))
    quantities = [common.completed(results), Quantity("peaks", len(found), len(theory), None)]
    for k, (there, here) in enumerate(zip(theory, found), 1):
        quantities.append(Quantity.near(f"frequency_{k}", here[0], there[0], FREQUENCY))
        quantities.append(Quantity.near(f"amplification_{k}", here[1], there[1], HEIGHT))
    work, balance = results.column("energy_external")[-1], results.column("energy_balance")[-1]
    quantities.append(Quantity("energy_missing", np.abs(balance) / work, None, 0.04))
    return quantities


def draw(results):
    import matplotlib.pyplot as plt

    frequency = np.arange(0.05, 9.0, 0.01)
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 4.2), layout="constrained")
    left.plot(results.column("time"), 1e3 * results.column("track_surface_vx"), linewidth=0.8)
    left.set(xlabel="time (s)", ylabel="velocity of the surface (mm/s)", xlim=(0.0, 5.0))
    right.plot(frequency, Column(results).transfer(frequency), color="0.3", label="damped column")
    right.plot(frequency, amplification(results, frequency), "--", label="Talus")
    right.set(xlabel="frequency (Hz)", ylabel="amplification")
    right.legend(fontsize="small")
    for axes in (left, right):
        axes.grid(alpha=0.3)
    return figure


if __name__ == "__main__":
    common.main(check, draw)
