#!/usr/bin/env python3
"""Expansion of a spherical cavity integrated in r: python3 spherical.py > reference.csv. README.md has the equations.

Units, signs and the rule are those of ../cavity_expansion/reference.py: lengths in radii of the cavity at the start, stresses in
pressures at the start, compression negative.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "cavity_expansion"))
from reference import FLOW, LAME, NU, RADII, RIM, SHEAR, STEPS, STRENGTH, root  # noqa: E402

YOUNG = 2.0 * SHEAR * (1.0 + NU)


def strains(radial, hoop):
    """Elastic logarithmic strains along the radius and round it of Kirchhoff stresses, beyond those at the start."""
    radial, hoop = radial + 1.0, hoop + 1.0
    return (radial - 2.0 * NU * hoop) / YOUNG, ((1.0 - NU) * hoop - NU * radial) / YOUNG


def answer(around, radial, start):
    """Radial logarithmic strain and Kirchhoff stresses along the radius and round it, of a strain round the cavity and Cauchy's
    radial stress."""
    wide = LAME + 2.0 * SHEAR
    across = root(lambda e: wide * e + 2.0 * LAME * around - 1.0 - radial * np.exp(e + 2.0 * around), start)
    tau, hoop = (wide * across + 2.0 * LAME * around - 1.0, 2.0 * (LAME + SHEAR) * around + LAME * across - 1.0)
    if tau < STRENGTH * hoop:  # flows
        def flow(e):
            tau = radial * np.exp(e + 2.0 * around)
            along, about = strains(tau, tau / STRENGTH)
            return FLOW * (e - along) + 2.0 * (around - about)
        across = root(flow, across)
        tau = radial * np.exp(across + 2.0 * around)
        hoop = tau / STRENGTH
    return across, tau, hoop


def profile(rim):
    """From the rim, with its radial stress, to the wall: r and Cauchy stresses along the radius and round it."""
    rows, y, guess = [], np.array([RIM, rim]), 0.0

    def slope(x, y):
        nonlocal guess
        around = np.log(y[0]) - x
        guess, tau, hoop = answer(around, y[1], guess)
        shrink, dr = np.exp(-guess - 2.0 * around), np.exp(guess + x)
        return np.array([dr, 2.0 * (hoop - tau) * shrink / y[0] * dr]), hoop * shrink

    places = np.linspace(np.log(RIM), 0.0, STEPS + 1)
    for x, h in zip(places, np.append(np.diff(places), 0.0)):
        one, hoop = slope(x, y)
        rows.append((*y, hoop))
        if h:
            two = slope(x + h / 2.0, y + h / 2.0 * one)[0]
            three = slope(x + h / 2.0, y + h / 2.0 * two)[0]
            y = y + h / 6.0 * (one + 2.0 * two + 2.0 * three + slope(x + h, y + h * three)[0])
    return np.array(rows)


def rim_stress(radius, start):
    """The radial stress at the rim for a wall at this radius."""
    return root(lambda rim: profile(rim)[-1, 0] - radius, start)


def main():
    print("# from spherical.py: wall's radius over the first one; pressures at the wall and the rim over that at the start")
    print("radius,wall,rim")
    rim = -1.001
    for radius in RADII:
        rim = rim_stress(radius, rim)
        print(f"{radius:.3f},{-profile(rim)[-1, 1]:.6f},{-rim:.6f}")


if __name__ == "__main__":
    main()
