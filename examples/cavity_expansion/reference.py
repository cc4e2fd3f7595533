#!/usr/bin/env python3
"""Cavity expansion integrated in r: python3 reference.py > reference.csv. README.md has the equations.

Lengths are in radii of the cavity at the start, stresses in pressures at the start, compression is negative. Unknowns are the
present radius r and Cauchy's radial stress at the first radius R, found from the rim inwards in ln R by the rule of Runge and
Kutta; the stress at the rim follows by secants from where the wall has to be.
"""
import numpy as np

RIM, SHEAR, NU, FRICTION, DILATION = 10.0, 50.0, 0.3, np.radians(30.0), np.radians(10.0)
LAME = 2.0 * SHEAR * NU / (1.0 - 2.0 * NU)
STRENGTH = (1.0 + np.sin(FRICTION)) / (1.0 - np.sin(FRICTION))  # radial stress over that round the cavity, flowing
FLOW = (1.0 + np.sin(DILATION)) / (1.0 - np.sin(DILATION))  # plastic: d round = -FLOW d radial
STEPS = 400
RADII = 1.0 + 0.005 * np.arange(1, 41)


def root(function, start):
    """Where a function of one number is zero, by secants."""
    one, other = start, start + 1e-4
    first, second = function(one), function(other)
    for _ in range(50):
        if abs(second) < 1e-11 or second == first:
            break
        one, other, first = other, other - second * (other - one) / (second - first), second
        second = function(other)
    return other


def strain(one, other):
    """Elastic logarithmic strain along the first of two Kirchhoff stresses, beyond that at the start; none along z."""
    return ((1.0 - NU) * (one + 1.0) - NU * (other + 1.0)) / (2.0 * SHEAR)


def answer(around, radial, start):
    """Radial logarithmic strain and Kirchhoff stresses, radial, round and along z, of a strain round the cavity and Cauchy's
    radial stress."""
    wide = LAME + 2.0 * SHEAR
    across = root(lambda e: wide * e + LAME * around - 1.0 - radial * np.exp(e + around), start)
    if wide * across + LAME * around - 1.0 < STRENGTH * (wide * around + LAME * across - 1.0):  # flows
        def flow(e):
            tau = radial * np.exp(e + around)
            return FLOW * (e - strain(tau, tau / STRENGTH)) + around - strain(tau / STRENGTH, tau)
        across = root(flow, across)
        tau = radial * np.exp(across + around)
        hoop = tau / STRENGTH
        assert tau < NU * (tau + hoop + 2.0) - 1.0 < hoop, "the stress along z is no longer the middle one"
    else:
        tau, hoop = wide * across + LAME * around - 1.0, wide * around + LAME * across - 1.0
    return across, tau, hoop, NU * (tau + hoop + 2.0) - 1.0


def profile(rim):
    """From the rim, with its radial stress, to the wall: r and Cauchy stresses, radial, round and along z."""
    rows, y, guess = [], np.array([RIM, rim]), 0.0

    def slope(x, y):
        nonlocal guess
        around = np.log(y[0]) - x
        guess, tau, hoop, along = answer(around, y[1], guess)
        shrink, dr = np.exp(-guess - around), np.exp(guess + x)
        return np.array([dr, (hoop - tau) * shrink / y[0] * dr]), (hoop * shrink, along * shrink)

    places = np.linspace(np.log(RIM), 0.0, STEPS + 1)
    for x, h in zip(places, np.append(np.diff(places), 0.0)):
        one, stress = slope(x, y)
        rows.append((*y, *stress))
        if h:
            two = slope(x + h / 2.0, y + h / 2.0 * one)[0]
            three = slope(x + h / 2.0, y + h / 2.0 * two)[0]
            y = y + h / 6.0 * (one + 2.0 * two + 2.0 * three + slope(x + h, y + h * three)[0])
    return np.array(rows)


def rim_stress(radius, start):
    """The radial stress at the rim for a wall at this radius."""
    return root(lambda rim: profile(rim)[-1, 0] - radius, start)


def ellipticity(dilation):
    """The least determinant of the acoustic tensor over normals in the plane while it flows, over that without flow, small strains,
    and the least and largest angle in degrees between the radius and normals for which it is below 0."""
    stiffness = LAME + 2.0 * SHEAR * np.eye(3)
    bound, flow = (np.array([np.sin(angle) - 1.0, np.sin(angle) + 1.0, 0.0]) for angle in (FRICTION, dilation))
    tangent = stiffness - np.outer(stiffness @ flow, bound @ stiffness) / (bound @ stiffness @ flow)
    angle = np.radians(np.linspace(0.0, 90.0, 9001))
    c, s = np.cos(angle), np.sin(angle)
    across = (tangent[0, 1] + SHEAR) * (tangent[1, 0] + SHEAR) * (c * s)**2
    value = (tangent[0, 0] * c**2 + SHEAR * s**2) * (tangent[1, 1] * s**2 + SHEAR * c**2) - across
    value /= SHEAR * (LAME + 2.0 * SHEAR)
    below = np.degrees(angle[value < -1e-9])
    return value.min(), (below[0], below[-1]) if len(below) else None


def main():
    print("# from reference.py: wall's radius over the first one; pressures at the wall and the rim over that at the start")
    print("radius,wall,rim")
    rim = -1.02
    for radius in RADII:
        rim = rim_stress(radius, rim)
        print(f"{radius:.3f},{-profile(rim)[-1, 1]:.6f},{-rim:.6f}")


if __name__ == "__main__":
    main()
