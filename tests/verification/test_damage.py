#!/usr/bin/env python3
"""Phase-field fracture: one homogeneous point by its closed form, and a bar that breaks.

A homogeneous point has no gradient of damage: (1 - eta) 2 (1 - d) psi+ = G_c w'(d)/(c_w l) gives d, and the stress
g(d) tau+ + tau-, by the energy of the neo-Hookean solid alone (physics/damage.c). A broken bar has dissipated
G_c A (1 + 3h/(8l)) with AT1 and linear elements, whose crack is a cell wide (Bourdin, Francfort and Marigo 2008,
doi:10.1007/s10659-007-9107-3, section 8, for AT1's profile).

Quick.
"""
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import brentq, minimize_scalar

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import FULL, Test, example  # noqa: E402

E, NU, G_C, L, ETA = 300.0, 0.25, 0.74, 0.1, 0.01
POINT = """mpm:
  dim: {dim}
  physics: damage
  grid: {{lower: "{low}", upper: "2,{one}", cells: "2,{ones}"}}
  shape: linear
  stabilization: {{fbar: false, ghost: "off"}}
  materials: binder
  material_binder: {{{kind}, E: 300, nu: 0.25, density: 1, toughness: 0.74, length: 0.1, residual: 0.01,
                     regularisation: {law}, split: {split}}}
  bodies: block
  body_block: {{region: box, lower: "{low}", upper: "1,{one}", points_per_cell: "{two}", material: binder}}
  bcs: left,right,sides
  bc_left: {{region: box, lower: "{low}", upper: "0,{one}", components: "x"}}
  bc_right: {{region: box, lower: "1,{zero}", upper: "1,{one}", components: "x", value: "{value!r}", ramp: "0:0,1:1"}}
  bc_sides: {{region: box, lower: "{low}", upper: "1,{one}", components: "{across}"}}
  damage: {{scheme: {scheme}, irreversible: {bound}, tolerance: {tolerance!r}}}
  time: {{end: 1, step: {step!r}}}
  output: {{every: 1}}
  quiet: true
"""
NEO = "type: neo_hookean, shear: isochoric, volumetric: quadratic"
SOUND = """mpm:
  dim: 2
  physics: damage
  grid: {lower: "0,0", upper: "3,2", cells: "6,4"}
  materials: rock
  material_rock: {type: neo_hookean, E: 1e6, nu: 0.25, density: 1000, toughness: 1e4, length: 1.25, regularisation: at1}
  bodies: block
  body_block: {region: box, lower: "0,0", upper: "2,2", points_per_cell: "3,3", material: rock}
  bcs: base,west
  bc_base: {region: box, lower: "0,0", upper: "3,0", components: "y"}
  bc_west: {region: box, lower: "0,0", upper: "0,2", components: "x"}
  loads: weight
  load_weight: {type: gravity, value: "0,-5"}
  time: {end: 1, step: 0.5}
  output: {every: 0}
  quiet: true
"""
CARRIED = """mpm:
  dim: 2
  physics: damage
  shape: gimp_bspline2
  grid: {lower: "0,0", upper: "6,2", cells: "24,8"}
  materials: rock
  material_rock: {type: hencky, E: 1e6, nu: 0.3, density: 1, toughness: 1e6, length: 1}
  bodies: block
  body_block: {region: box, lower: "0.5,0", upper: "2.5,2", points_per_cell: "2,2", material: rock, initial_damage: 0.3}
  motions: way
  motion_way: {body: block, components: "x,y", value: "3,0"}
  time: {end: 1, step: 0.1}
  output: {every: 0}
  quiet: true
"""
BAR = """mpm:
  dim: 2
  physics: damage
  grid: {{lower: "0,0", upper: "{upper!r},{h!r}", cells: "{cells},1"}}
  shape: linear
  materials: bar,weak
  material_bar: {{type: neo_hookean, shear: isochoric, volumetric: quadratic, E: 3e7, nu: 0, density: 1, toughness: 0.74,
                  length: 0.1, regularisation: {law}}}
  material_weak: {{type: neo_hookean, shear: isochoric, volumetric: quadratic, E: 3e7, nu: 0, density: 1,
                   toughness: 0.7252, length: 0.1, regularisation: {law}}}
  bodies: a,b,c
  body_a: {{region: box, lower: "0,0", upper: "{a!r},{h!r}", points_per_cell: "2,2", material: bar}}
  body_b: {{region: box, lower: "{a!r},0", upper: "{b!r},{h!r}", points_per_cell: "2,2", material: weak}}
  body_c: {{region: box, lower: "{b!r},0", upper: "2,{h!r}", points_per_cell: "2,2", material: bar}}
  bcs: left,right,sides
  bc_left: {{region: box, lower: "0,0", upper: "0,{h!r}", components: "x,d"}}
  bc_right: {{region: box, lower: "2,0", upper: "2,{h!r}", components: "x,d", value: "0.0012,0", ramp: "0:0,1:1"}}
  bc_sides: {{region: box, lower: "0,0", upper: "2,{h!r}", components: "y"}}
  damage: {{scheme: {scheme}, irreversible: {bound}}}
  time: {{end: {end!r}, step: {step!r}}}
  output: {{every: 0}}
  quiet: true
"""


def energies(stretch):
    """psi+ and psi-, and the nominal stresses of both, of uniaxial strain."""
    mu, bulk = E / (2.0 * (1.0 + NU)), E / (3.0 * (1.0 - 2.0 * NU))
    first = stretch**2 + 2.0
    volume = 0.25 * bulk * (stretch**2 - 1.0 - 2.0 * np.log(stretch))
    pressure = 0.5 * bulk * (stretch - 1.0 / stretch)
    shape = 0.5 * mu * (stretch ** (-2.0 / 3.0) * first - 3.0)
    shear = mu * (stretch ** (1.0 / 3.0) - first / 3.0 * stretch ** (-5.0 / 3.0))
    return (shape + volume, 0.0, shear + pressure, 0.0) if stretch >= 1.0 else (shape, volume, shear, pressure)


def answer(stretch, law="at2", split="volumetric"):
    """Damage and nominal stress at a stretch that has grown steadily."""
    plus, minus, stress, rest = energies(stretch)
    if split == "none":
        plus, stress, rest = plus + minus, stress + rest, 0.0
    drive = 2.0 * (1.0 - ETA) * plus
    d = drive / (drive + G_C / L) if law == "at2" else max(0.0, 1.0 - 3.0 * G_C / (8.0 * L) / max(drive, 1e-300))
    return d, ((1.0 - ETA) * (1.0 - d) ** 2 + ETA) * stress + rest


def point(test, dim=2, value=0.12, step=0.02, law="at2", split="volumetric", scheme="monolithic", bound="bounds",
          tolerance=1e-6, ranks=1, kind=NEO, answer=answer, **options):
    """Largest differences of damage and stress from the closed form, over the largest of each; and the last state's."""
    path = test.folder() / "point.yaml"
    zero, one = ",".join(["0"] * (dim - 1)), ",".join(["1"] * (dim - 1))
    path.write_text(POINT.format(kind=kind, dim=dim, low="0," + zero, zero=zero, one=one, ones=one, two=",".join(["2"] * dim),
                                 law=law, split=split, scheme=scheme, bound=bound, tolerance=tolerance, value=value, step=step,
                                 across="y" if dim == 2 else "y,z"))
    results = test.run(path, ranks=ranks, **options).results
    rows = []
    for state in [results.state(k) for k in range(0, round(1.0 / step) + 1)]:
        stretch = state["F"][0, 0]
        rows.append([state["damage"].ravel()[0], state["stress"][0, 0], *answer(stretch, law, split)])
    rows = np.array(rows)
    return abs(rows[:, 0] - rows[:, 2]).max(), abs(rows[:, 1] - rows[:, 3]).max() / abs(rows[:, 3]).max(), rows[-1, :2]


def spectral(stretch, law, split):
    """Small strains along x and y of opposite sign; each step changes both lengths by 1/500."""
    shear, lame = E / (2.0 * (1.0 + NU)), E * NU / ((1.0 + NU) * (1.0 - 2.0 * NU))
    along, across = stretch - 1.0, 1.002 ** (np.log(stretch) / np.log(0.998)) - 1.0
    drive = 2.0 * (1.0 - ETA) * (0.5 * lame * (along + across) ** 2 + shear * across**2)
    d = drive / (drive + G_C / L)
    return d, ((1.0 - ETA) * (1.0 - d) ** 2 + ETA) * lame * (along + across) + 2.0 * shear * along


def bar(test, cells, law, step=0.002, end=0.512, ranks=1, scheme="monolithic", bound="bounds"):
    """Stress over its peak, and dissipation over G_c A, in the first step after the break."""
    h = 2.0 / cells
    a = cells // 2 * h
    path = test.folder() / "bar.yaml"
    path.write_text(BAR.format(upper=2.0 + 4.0 * h, h=h, cells=cells + 4, a=a, b=a + h, law=law, step=step, end=end,
                               scheme=scheme, bound=bound))
    history = test.run(path, ranks=ranks).results.history
    force, energy = np.array(history["reaction_right_x"]), np.array(history["energy_fracture"])
    after = int(np.argmax(np.array(history["damage_max"]) > 0.9))
    return force[after] / force.max(), energy[after] / (G_C * h), force.max() / h, after


def broken_cell(test, cells, law):
    """Energy over G_c A of a bar at rest with one cell that is broken from the start, so many cells a length."""
    h = L / cells
    path = test.folder() / "cell.yaml"
    path.write_text(BAR.format(upper=81 * h, h=h, cells=81, a=40 * h, b=41 * h, law=law, step=1.0, end=1.0,
                               scheme="monolithic", bound="bounds"))
    end = f"{81 * h!r},{h!r}"
    run = test.run(path, mpm_body_b_initial_damage=1, mpm_body_c_upper=end, mpm_material_weak_toughness=G_C, mpm_bcs="sides",
                   mpm_bc_sides_components="x,y", mpm_bc_sides_upper=end)
    return float(run.results.history["energy_fracture"][-1]) / (G_C * h)


def sound(test):
    """A block that AT1 leaves sound is solved in two steps, whatever the shape: nothing but its bound holds its damage."""
    folder = test.folder()
    for name, shape, options in (("gimp", "gimp", {"mpm_damage_irreversible": "history"}), ("bspline2", "bspline2", {}),
                                 ("order2", "gimp_element", {"mpm_order": 2})):
        (folder / "sound.yaml").write_text(SOUND)
        run = test.run(folder / "sound.yaml", mpm_shape=shape, **options)
        test.check(f"sound.{name}.damage", float(abs(run.results.column("damage_max")[-1])), None, 1e-5)
        test.check(f"sound.{name}.newton", float(sum(run.results.column("newton"))), None, 10)


def carried(test):
    """A block with damage from the start that moves as a whole: nothing changes, and a step takes one iteration."""
    path = test.folder() / "carried.yaml"
    path.write_text(CARRIED)
    run = test.run(path, status=None)
    test.check("carried.status", run.status, 0, 0)
    history = run.results.history
    test.check("carried.newton", float(max(history["newton"][1:])), None, 2)
    test.near("carried.damage", history["damage_max"][-1], 0.3, relative=1e-5)
    test.near("carried.energy", history["energy_fracture"][-1], 4e6 * 0.5 * 0.3**2, relative=1e-5)


def refused(test):
    """Numbers of damage out of their ranges; a warning of a length below two cells."""
    scene, short = example("broken_bar"), {"mpm_time_end": 1, "mpm_output_every": 0}
    for name, options in (("toughness 0", {"mpm_material_bar_toughness": 0}), ("length -1", {"mpm_material_bar_length": -1}),
                          ("residual 2", {"mpm_material_bar_residual": 2}), ("split half", {"mpm_material_bar_split": "half"}),
                          ("regularisation at3", {"mpm_material_weak_regularisation": "at3"}),
                          ("initial_damage 1.5", {"mpm_body_middle_initial_damage": 1.5})):
        run = test.run(scene, status=2, **options)
        test.check(f"refused.{name}", int(f"_{name}: must" in run.errors + run.output), 1)
    for length, warned in ((0.04, 1), (0.05, 0)):
        run = test.run(scene, mpm_material_bar_length=length, **short)
        test.check(f"length_{length}.warning", (run.errors + run.output).count("is less than two cells"), warned, warned)


with Test() as test:
    best = minimize_scalar(lambda s: -answer(s)[1], bounds=(1.0, 1.2), method="bounded", options={"xatol": 1e-10})
    test.near("closed.peak", -best.fun, 16.278030, relative=1e-6)
    test.near("closed.compressed", answer(0.8)[1], -55.567146, relative=1e-6)
    onset = brentq(lambda s: 2.0 * (1.0 - ETA) * energies(s)[0] - 3.0 * G_C / (8.0 * L), 1.0, 1.2)
    test.near("closed.onset", energies(onset)[2], 30.377624, relative=1e-6)
    for name, options in (("at2", {}), ("at1", {"law": "at1"}), ("at1_tight", {"law": "at1", "tolerance": 1e-8}),
                          ("history", {"bound": "history"}), ("3d", {"dim": 3}), ("compressed", {"value": -0.2}),
                          ("split_none", {"value": -0.2, "split": "none"}), ("ranks_3", {"ranks": 3})):
        d, stress, last = point(test, **options)
        test.check(f"{name}.damage", d, None, 1e-7 if "tight" in name else 1e-5)
        test.check(f"{name}.stress", stress, None, 1e-5)
    options = {"mpm_bcs": "left,right,sides,top", "mpm_bc_sides_upper": "1,0", "mpm_bc_top_region": "box", "mpm_bc_top_lower": "0,1",
               "mpm_bc_top_upper": "1,1", "mpm_bc_top_components": "y", "mpm_bc_top_value": 0.1, "mpm_bc_top_ramp": "0:0,1:1"}
    d, stress, last = point(test, value=-0.1, split="spectral", kind="type: linear_elastic", answer=spectral, **options)
    test.check("spectral.damage", d, None, 1e-5)
    test.check("spectral.stress", stress, None, 1e-5)
    together, in_turn = bar(test, 81, "at1"), bar(test, 81, "at1", scheme="staggered")
    fine, history = bar(test, 161, "at1"), bar(test, 81, "at1", bound="history")
    for name, found, cells in (("bar_81", together, 81), ("bar_161", fine, 161)):
        test.check(f"{name}.stress_left", found[0], None, 2e-3)
        test.near(f"{name}.energy", found[1], 1.0 + 3.0 * 2.0 / cells / (8.0 * L), relative=0.01)
        test.check(f"{name}.broken", float(found[3]), 1.0)
    test.near("bar_history.energy", history[1], 1.35, relative=0.03)
    test.near("schemes.energy", in_turn[1], together[1], relative=1e-4)
    test.near("schemes.peak", in_turn[2], together[2], relative=1e-6)
    for law, cells, energy in (("at2", 4, 1.127601), ("at2", 8, 1.063151), ("at1", 4, 1.095703), ("at1", 8, 1.047363)):
        test.near(f"broken_cell.{law}.{cells}", broken_cell(test, cells, law), energy, relative=2e-3)
    test.check_example("broken_bar", test.run(example("broken_bar"), mpm_quiet=None), "broken_bar")
    coarse = {"mpm_grid_cells": "32,34", "mpm_grid_lower": "0,-0.03125", "mpm_grid_upper": "1,1.03125", "mpm_time_end": 0.4,
              "mpm_output_every": 0}
    slot = test.run(example("slot_crack"), mpm_solver="direct", **coarse).results.history
    test.check("slot.iterations", max(slot["newton"][1:]), None, 6)  # bounds of unknowns: 3; at points 50 to 150
    for name, ranks, options in (("1", 1, {}), ("3", 3, {}), ("matfree", 1, {"mpm_jacobian": "matfree"}),
                                 ("staggered", 1, {"mpm_damage_scheme": "staggered"})):
        found = test.run(example("slot_crack"), ranks=ranks, mpm_solver="damage-fieldsplit", **options, **coarse).results.history
        for column in ("reaction_high_y", "energy_fracture", "damage_max"):
            apart = np.max(np.abs(np.array(found[column]) - np.array(slot[column]))) / np.max(np.abs(slot[column]))
            test.check(f"blocks.{name}.{column}", apart, None, 1e-5 if name == "staggered" else 1e-8)
        test.check(f"blocks.{name}.iterations", sum(found["linear"]) / sum(found["newton"]), None, 8)  # 4 to 6
    sound(test)
    carried(test)
    refused(test)
    press = test.run(example("press"), mpm_time_end=0.3, mpm_output_every=0)
    test.check_example("press", press, "press")
    test.check("press.newton", float(sum(press.results.column("newton"))), None, 200)  # 141
    ranks = test.run(example("press"), ranks=3, mpm_time_end=0.1, mpm_output_every=0).results.history
    for column in ("reaction_top_z", "energy_fracture"):
        test.near(f"press.ranks.{column}", ranks[column][1], press.results.history[column][1], relative=1e-6)
    if FULL:  # minutes
        test.check_example("slot_crack", test.run(example("slot_crack"), mpm_quiet=None), "slot_crack")
