#!/usr/bin/env python3
"""Nor-Sand in the laboratory: the example's tests on loose and dense sand against an independent program, with fewer steps, and
what it does that theory says: critical state, undrained and isotropic compression, plane strain; scenes that it refuses.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Run, Test, example  # noqa: E402

M, N, LAMBDA, V_C0, KAPPA, G = 1.27, 0.4, 0.02, 1.8911, 0.0015, 45e6
SAND = {"type": "nor_sand", "kappa": KAPPA, "G": G, "M": M, "N": N, "lambda": LAMBDA, "v_c0": V_C0, "h": 120,
        "specific_volume": 1.6, "image_pressure": 150e3, "reference_pressure": 200e3}
ISOTROPIC = "-200e3,-200e3,-200e3,0,0,0"
DENSE = {"mpm_point_material": "dense", "mpm_point_stress": "-275284.0909090909,-724431.8181818181,-275284.0909090909,0,0,0"}


def start(test, law, files=(), **options):
    """A run with one material in a folder of its own, whatever its end; options without mpm_point_ or with mpm_."""
    lines = {"mpm_dim": 3, "mpm_physics": "stress_point", "mpm_materials": "sand", "mpm_point_material": "sand",
             "mpm_output_prefix": "run", "mpm_quiet": "true", "mpm_point_measure": "kirchhoff"}
    lines.update({f"mpm_material_sand_{name}": value for name, value in law.items()})
    lines.update({name if name.startswith("mpm_") else "mpm_point_" + name: value for name, value in options.items()})
    folder = test.folder()
    for name, text in dict(files).items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "scene.yaml").write_text("".join(f'{name}: "{value}"\n' for name, value in lines.items() if value is not None),
                                       encoding="utf-8")
    return Run(test.program, folder / "scene.yaml", 1, {}, folder)


def follow(test, law, **options):
    run = start(test, law, **options)
    if run.status:
        sys.exit(f"exit status {run.status}: {options}\n{run.output}\n{run.errors}")
    return run.results.history


def check_reference(test):
    """The example itself, and that fewer steps end, without cuts, within what backward Euler makes of them."""
    for name, options in (("loose", {}), ("dense", DENSE)):
        for steps in (500, 100, 50, 25):
            run = test.run(example("nor_sand_triaxial"), mpm_quiet=None, mpm_point_steps=steps, **options)
            if steps >= 100:
                test.check_example(f"{name}_{steps}", run, "nor_sand_triaxial")
            test.check(f"{name}_{steps}.rows", len(run.results.column("time")), steps, steps)
            test.check(f"{name}_{steps}.cuts", run.results.column("cuts").sum(), 0, 0)


def excess(history, N=N):
    """The yield function over |p|, largest of a history."""
    p, p_i = -history["p"], history["image_pressure"]
    eta = M / N * (1 - (1 - N) * (p / p_i) ** (N / (1 - N))) if N else M * (1 + np.log(p_i / p))
    return (history["q"] / p - eta).max()


def check_critical_state(test):
    """Sheared far, loose and dense, compressed and extended, the sand comes to q = -M p and to the critical state line, and its
    volume stays; on the way the stress is on the yield surface."""
    for volume, end, curvature in ((1.72, -1.5, 0), (1.72, 1.5, N), (1.9, -1.5, N), (1.9, 1.5, 0)):
        law = {**SAND, "specific_volume": volume, "N": curvature}
        history = follow(test, law, path="triaxial_drained", end=end, steps=200, stress=ISOTROPIC)
        label, last = f"critical_{volume}_{end}", {key: column[-1] for key, column in history.items()}
        test.near(label + ".eta", last["q"] / -last["p"], M, 1e-3)
        test.check(label + ".volume", abs(history["eps_v"][-1] - history["eps_v"][-10]), None, 2e-4)
        test.near(label + ".line", last["specific_volume"], V_C0 - LAMBDA * np.log(-last["p"] / 1e3), 1e-3)
        test.check(label + ".yield", excess(history, curvature), None, 1e-9)
        test.near(label + ".v", last["specific_volume"], volume * np.exp(last["eps_v"]), 1e-12)


def check_undrained(test):
    """At constant volume loose sand loses its pressure, dense sand gains it; both go to the critical state of their volume."""
    for volume, sign in ((1.82, -1), (1.76, 1)):
        history = follow(test, {**SAND, "specific_volume": volume, "kappa": 0.005}, path="triaxial_undrained", end=-3,
                         steps=400, stress=ISOTROPIC)
        critical = 1e3 * np.exp((V_C0 - volume) / LAMBDA)
        test.near(f"undrained_{volume}.p", -history["p"][-1], critical, 2e-3)
        test.near(f"undrained_{volume}.q", history["q"][-1], M * critical, 2e-3)
        test.check(f"undrained_{volume}.way", sign * (-history["p"][-1] - 200e3), 0)


def check_isotropic(test):
    """Elastic up to the preconsolidation, e_v = -kappa ln p; from there p/p_i is that of the surface's tip, where no shear
    stiffness is left: strain has to be prescribed."""
    law = {name: value for name, value in SAND.items() if name != "image_pressure"}
    law["preconsolidation"] = 400e3
    history = follow(test, law, path="isotropic", end=399e3, steps=10, stress=ISOTROPIC)
    test.check("isotropic.elastic", np.abs(history["eps_v"] + KAPPA * np.log(-history["p"] / 200e3)).max(), None, 1e-13)
    columns = ",".join("strain_" + name for name in ("xx", "yy", "zz"))
    history = follow(test, law, path="table", table="path.csv", steps=40, stress=ISOTROPIC,
                     files={"path.csv": f"time,{columns}\n1,-0.002,-0.002,-0.002\n"})
    p, tip = -history["p"], (1 - N) ** (-(1 - N) / N)
    flows = p > 401e3
    test.check("isotropic.steps", flows.sum(), 25, 39)
    test.check("isotropic.tip", np.abs(p / history["image_pressure"] / tip - 1)[flows].max(), None, 1e-10)
    test.check("isotropic.q", history["q"].max(), None, 1e-6)
    test.check("isotropic.softer", np.log(p[-1] / 200e3) * KAPPA / 0.006, 0.2, 0.9)


def check_plane_strain(test):
    space = follow(test, SAND, path="biaxial_drained", end=-0.05, steps=50, stress=ISOTROPIC)
    plane = follow(test, SAND, path="biaxial_drained", end=-0.05, steps=50, stress="-200e3,-200e3,-200e3,0", mpm_dim=2)
    six = follow(test, SAND, path="biaxial_drained", end=-0.05, steps=50, stress=ISOTROPIC, mpm_dim=2)
    test.check("plane_strain.six_stresses", np.abs(six["stress_yy"] - plane["stress_yy"]).max(), None, 0)
    for name in ("stress_yy", "stress_zz", "q", "eps_v", "image_pressure", "specific_volume"):
        test.check(f"plane_strain.{name}", np.abs(space[name] / plane[name] - 1).max(), None, 1e-9)


BAD = (
    ("N_of_one", {"N": 1}, "-mpm_material_sand_N 1: must lie in [0, 0.95]"),
    ("N_below_zero", {"N": -0.1}, "-mpm_material_sand_N -0.1: must lie in [0, 0.95]"),
    ("no_kappa", {"kappa": None}, "-mpm_material_sand_kappa is missing"),
    ("kappa_of_zero", {"kappa": 0}, "-mpm_material_sand_kappa 0: must be > 0"),
    ("no_hardening", {"h": None}, "-mpm_material_sand_h is missing"),
    ("volume_of_grains", {"specific_volume": 1}, "-mpm_material_sand_specific_volume 1: must be > 1"),
    ("both", {"preconsolidation": 400e3}, "only one of image_pressure, preconsolidation, ocr and pop can be given"),
    ("neither", {"image_pressure": None}, "one of image_pressure (Pa, > 0), preconsolidation (Pa, > 0), ocr (-, >= 1) and pop (Pa, >= 0) is missing"),
    ("foreign", {"friction": 30}, "-mpm_material_sand_friction: unknown option"),
)


def check_refusals(test):
    cases = [(name, {**SAND, **change}, ISOTROPIC, line) for name, change, line in BAD]
    cases += [("tension", SAND, "1e3,1e3,1e3,0,0,0", "material sand has no state with this stress"),
              ("beyond_strength", SAND, "-200e3,-800e3,-200e3,0,0,0", "material sand cannot bear it")]
    for name, law, stress, line in cases:
        run = start(test, {key: value for key, value in law.items() if value is not None}, path="triaxial_drained", end=-0.1,
                    stress=stress)
        told = [words for words in run.errors.splitlines() if words.startswith("talus: error:")]
        good = run.status == 2 and len(told) == 1 and line in told[0] and "PETSC ERROR" not in run.errors
        test.check(f"refuses.{name}", good, 1, 1)
        if not good:
            print(f"    status {run.status}: {run.errors.strip()[:500]}")


with Test() as test:
    for check in (check_reference, check_critical_state, check_undrained, check_isotropic, check_plane_strain, check_refusals):
        check(test)
