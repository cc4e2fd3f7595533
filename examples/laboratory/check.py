#!/usr/bin/env python3
"""Compares a run of laboratory, of whichever law, with its closed form; draws it with the others' runs that lie beside it."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402
from results import Results  # noqa: E402

EXACT = 1e-10  # of the largest value: steps of any length make no error on these paths
LAGGED = 0.01  # the same with strength that is of the step's start: first order
TURNING = 2e-4  # with a rate whose axes turn within steps: second order
BREAKING = 10  # steps in which such a strength vanishes


def parameter(results, name):
    return float(results.option(f"mpm_material_{law(results)}_{name}"))


def law(results):
    return results.option("mpm_point_material")


def moduli(results):
    """Lame's constants and the bulk modulus."""
    E, nu = parameter(results, "E"), parameter(results, "nu")
    shear = E / (2.0 * (1.0 + nu))
    return E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), shear, E / (3.0 * (1.0 - 2.0 * nu))


def confining(results):
    return results.numbers("mpm_point_stress")[0]


# ---- closed forms: columns of the history, from the strain that is prescribed ----

def linear_elastic(results, history):
    """Oedometer: the stress follows the displacement gradient, whatever its size."""
    lame, shear, _ = moduli(results)
    strain = history["strain_yy"]
    return {"stress_yy": (lame + 2.0 * shear) * strain, "stress_xx": lame * strain}


def hencky(results, history):
    """Simple shear gamma: principal logarithmic strains +-asinh(gamma/2), at half the angle atan(2/gamma)."""
    shear = moduli(results)[1]
    gamma = history["time"] * float(results.option("mpm_point_end"))
    size, root = np.arcsinh(gamma / 2.0), np.sqrt(4.0 + gamma**2)
    return {"stress_xy": 2.0 * shear * size * 2.0 / root, "stress_xx": 2.0 * shear * size * gamma / root}


def neo_hookean(results, history):
    """Oedometer, Kirchhoff stress: tau = mu (b - I) + lambda ln J I with b_yy = J^2."""
    lame, shear, _ = moduli(results)
    strain = history["strain_yy"]
    return {"stress_yy": shear * np.expm1(2.0 * strain) + lame * strain, "stress_xx": lame * strain}


def jaumann_elastic(results, history):
    """Simple shear gamma: the rate turns the stress by half of gamma, sigma_xy = mu sin(gamma), sigma_xx = mu (1 - cos(gamma))."""
    shear = moduli(results)[1]
    gamma = history["time"] * float(results.option("mpm_point_end"))
    return {"stress_xy": shear * np.sin(gamma), "stress_xx": shear * (1.0 - np.cos(gamma))}


def newtonian(results, history):
    """
    Oedometer at a constant rate of the logarithmic strain, Kirchhoff stress: tau = -J p I + 2 mu J_n dev d, J_n of the step's start, with
    p = (K/7) (J^-7 - 1).
    """
    mu, bulk = parameter(results, "viscosity"), parameter(results, "density") * parameter(results, "sound_speed") ** 2
    strain = history["strain_yy"]
    before = np.concatenate(([0.0], strain[:-1]))
    rate = (strain - before) / history["dt"]
    pressure, viscous = np.exp(strain) * bulk / 7.0 * np.expm1(-7.0 * strain), 2.0 / 3.0 * mu * np.exp(before) * rate
    return {"stress_yy": -pressure + 2.0 * viscous, "stress_xx": -pressure - viscous, "volume_ratio": np.exp(strain)}


def j2(results, history):
    """Undrained shear: q = 3 G e_q up to the yield stress, from there with the slope 3 G H/(3 G + H); p stays."""
    triple, hardening = 3.0 * moduli(results)[1], parameter(results, "hardening")
    start, strain = parameter(results, "yield_stress"), np.abs(history["strain_yy"])
    flowing = (start + hardening * strain) / (1.0 + hardening / triple)
    q = np.minimum(triple * strain, flowing)
    return {"q": q, "p": np.full_like(q, confining(results)), "equivalent_plastic_strain": strain - q / triple}


def mohr_coulomb(results, history):
    """Drained plane strain: Hooke's law, then the strength under the held stress, and dilation at a fixed rate."""
    E, nu = parameter(results, "E"), parameter(results, "nu")
    sine, cosine = (function(np.radians(parameter(results, "friction"))) for function in (np.sin, np.cos))
    dilation = np.sin(np.radians(parameter(results, "dilation")))
    held, strain = confining(results), np.abs(history["strain_yy"])
    strength = (2.0 * parameter(results, "cohesion") * cosine - 2.0 * held * sine) / (1.0 - sine)  # over the held stress
    grown = np.minimum(E / (1.0 - nu**2) * strain, strength)
    flow = (strain - grown * (1.0 - nu**2) / E) / (1.0 - dilation)  # multiplier
    elastic = -(1.0 + nu) * (1.0 - 2.0 * nu) / E * grown
    return {"stress_yy": held - grown, "stress_zz": held - nu * grown, "eps_v": elastic + 2.0 * dilation * flow}


def nacc(results, history):
    """
    Equal compression and expansion, with a = alpha_0 + v. Compaction: p = p_0(a), ln J = ln(1 - 2 p/K)/2 + v. Back from there v
    stays, down to -beta p_0: it breaks, for p_0 then falls faster than p can, and -beta K 1e-5 is left.
    """
    bulk, turn = moduli(results)[2], int(np.argmin(history["eps_v"]))

    def strength(v):
        return bulk * (1e-5 + np.sinh(parameter(results, "xi") * np.maximum(-parameter(results, "alpha_0") - v, 0.0)))

    def elastic(volume):
        return -bulk / 2.0 * np.expm1(2.0 * volume)

    v = np.linspace(-0.015, 0.0, 20001)  # p_0 is above K/2, which elasticity does not bear, at the end on the left
    v = v[2.0 * strength(v) < bulk]
    way, down, up = 0.5 * np.log(1.0 - 2.0 * strength(v) / bulk) + v, history["eps_v"][:turn + 1], history["eps_v"][turn + 1:]
    p, plastic = np.zeros_like(history["eps_v"]), np.zeros_like(history["eps_v"])
    plastic[:turn + 1] = np.interp(down, way, v)
    p[:turn + 1] = elastic(down - plastic[:turn + 1])
    tension = -parameter(results, "beta") * strength(plastic[turn])
    broken = elastic(up - plastic[turn]) < tension
    left = -parameter(results, "beta") * strength(1.0)
    p[turn + 1:] = np.where(broken, left, elastic(up - plastic[turn]))
    plastic[turn + 1:] = np.where(broken, up - 0.5 * np.log(1.0 - 2.0 * left / bulk), plastic[turn])
    start = turn + 1 + int(np.argmax(broken))
    p[start:start + BREAKING] = plastic[start:start + BREAKING] = np.nan
    return {"p": -p, "plastic_volume_strain": plastic}


BOUNDS = {"nacc": LAGGED, "jaumann_elastic": TURNING}
THEORY = {function.__name__: function for function in (linear_elastic, hencky, neo_hookean, jaumann_elastic, newtonian,
                                                         j2, mohr_coulomb, nacc)}
# what is drawn: columns across and up, and what they are called
AXES = {"linear_elastic": ("strain_yy", "stress_yy"), "hencky": ("gamma", "stress_xy"), "neo_hookean": ("strain_yy", "stress_yy"),
        "jaumann_elastic": ("gamma", "stress_xy"), "newtonian": ("strain_yy", "stress_yy"), "j2": ("strain_yy", "q"),
        "mohr_coulomb": ("strain_yy", "stress_yy"), "nacc": ("eps_v", "p")}

LABELS = {"strain_yy": r"$-\varepsilon_{yy}$", "stress_yy": r"$-\tau_{yy}$", "stress_xy": r"$\tau_{xy}$", "gamma": r"$\gamma$",
          "q": "$q$", "eps_v": r"$-\ln J$", "p": "$-p$"}


def check(results):
    history = results.history
    quantities = [common.completed(results)]
    for name, exact in THEORY[law(results)](results, history).items():
        error = np.nanmax(np.abs(history[name] - exact)) / np.nanmax(np.abs(exact))
        bound = BOUNDS.get(law(results), EXACT)
        quantities.append(Quantity("error_" + name, error, None, bound))
    if law(results) != "nacc":
        quantities.append(Quantity("newton_max", history["newton"].max(), None, 3))
    return quantities


def draw(results):
    """A panel a law, for those whose runs lie beside this one under the same name with the law's at its end."""
    import matplotlib.pyplot as plt

    prefix = str(results.prefix)
    stem = prefix[:-len(law(results))] if prefix.endswith(law(results)) else None
    runs = {name: Results(stem + name) for name in THEORY if stem and Path(f"{stem}{name}_summary.json").exists()}
    runs[law(results)] = results
    across = min(3, len(runs))
    figure, axes = plt.subplots(-(-len(runs) // across), across, squeeze=False, layout="constrained",
                                figsize=(4.2 * across, 3.3 * -(-len(runs) // across)))
    for panel, name in zip(axes.flat, [name for name in THEORY if name in runs]):
        history = runs[name].history
        exact, (x, y) = THEORY[name](runs[name], history), AXES[name]
        history["gamma"] = history["time"] * float(runs[name].option("mpm_point_end", "0"))
        shown = slice(None, None, max(1, len(history["time"]) // 25))
        along, up = (-1.0 if "-" in LABELS[column] else 1.0 for column in (x, y))
        panel.plot(along * history[x], up * exact[y] / 1e3, color="0.3", linewidth=1.2, label="closed form")
        panel.plot(along * history[x][shown], up * history[y][shown] / 1e3, "o", markersize=4, markerfacecolor="none",
                   label="Talus")
        panel.set(title=name, xlabel=LABELS[x], ylabel=LABELS[y] + " (kPa)")
        panel.grid(alpha=0.3)
    axes.flat[len(runs) - 1].legend()
    for panel in axes.flat[len(runs):]:
        panel.remove()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
