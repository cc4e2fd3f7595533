"""An installed Talus is all that a program or a plugin needs.

Installs into an empty prefix, and builds tests/installed/ against that alone, once through find_package() and once through
pkg-config: a program in which two models exchange loads through hooks, with the shared library and with the static one,
and a plugin with a law, a physics of two fields and a term, whose Jacobian must be the same in all forms. The term's springs
carry a block that moves without strain: its equilibrium and its oscillation are known, step by step. A paraboloid of the
plugin is pressed into a block: near its tip it is the sphere that is built in, and under a load it comes to rest. Three
programs each add something from one file: a field of the points, columns of the history, and numbers that checkpoints hold.

Quick.
"""
import math
import shlex
import shutil
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ENVIRONMENT, ROOT, Run, Test, call, must  # noqa: E402

SOURCES = ROOT / "tests" / "installed"
FORMS = ("coloring", "dense", "matfree", "matfree_without_tangents")
PLUGIN_FAULTS = {"nowhere.so": "-mpm_plugin nowhere.so: cannot be loaded",
                 "tied.c": "-mpm_plugin tied.c: cannot be loaded"}
SPRING_FAULTS = ((("-mpm_term_left_type", "rope"), "-mpm_term_left_type rope: is no type of term; there is foundation"),
                 (("-mpm_term_left_stiffness", "-1"), "-mpm_term_left_stiffness -1: must lie in"),
                 (("-mpm_time_integrator", "explicit"), "-mpm_terms: need steps that are not explicit"))

DIE_FAULTS = ((("-mpm_boundary_die_type", "bowl"), "must be one of plane, box, sphere, cylinder, cone, polygon, stl, terrain, paraboloid"),
              (("-mpm_boundary_die_type", "paraboloid"), "-mpm_boundary_die_tip is missing"))


def install(test, build, prefix):
    """Installs the build tree, and looks that all is there and nothing else is."""
    must(test, "install", ["cmake", "--install", build, "--prefix", prefix], build)
    for file in ("bin/talus", "lib/libtalus.a", "lib/libtalus.so", "include/talus/talus.h", "include/talus/plugin.h",
                 "include/talus/contact.h", "include/talus/point/law.h", "libexec/talus/test_laws_2d", "libexec/talus/test_laws_3d", "lib/cmake/Talus/TalusConfig.cmake", "lib/pkgconfig/talus.pc", "share/man/man1/talus.1",
                 "share/bash-completion/completions/talus", "share/zsh/site-functions/_talus", "share/talus/talus.schema.json",
                 "share/doc/talus/README.md", "share/doc/talus/LICENSE", "share/doc/talus/docs/first-run.md",
                 "share/doc/talus/examples/cantilever/check.py", "share/doc/talus/scripts/results.py", "share/talus/scripts/plot.py"):
        test.check(file, int((prefix / file).exists()), 1, 1)
    public = {path.relative_to(ROOT / "include") for path in (ROOT / "include").rglob("*.h")}
    installed = {path.relative_to(prefix / "include") for path in (prefix / "include").rglob("*") if path.is_file()}
    test.check("other_headers", len(public ^ installed), 0, 0)
    for file in prefix.rglob("*"):  # what leads back to the sources would break where they are not
        if file.suffix in (".cmake", ".pc", ".h", ".in"):
            test.check(f"{file.name}:names_the_sources", int(str(ROOT) in file.read_text()), 0, 0)


def with_pkg_config(test, prefix, folder):
    """The same program, by one line with pkg-config."""
    ENVIRONMENT["PKG_CONFIG_PATH"] = str(prefix / "lib" / "pkgconfig")
    flags = shlex.split(must(test, "pkg_config", ["pkg-config", "--cflags", "--libs", "talus"], folder))
    must(test, "compile", ["cc", "-std=c11", SOURCES / "tied.c", "-o", "tied_pc", *flags], folder)


def petsc_by_variables(test, top):
    """PETSc is found by PETSC_DIR and PETSC_ARCH, and a wrong folder is named."""
    found = must(test, "petsc_prefix", ["pkg-config", "--variable=prefix", "PETSc"], top).strip()
    for folder, arch, status in ((Path(found).parent, Path(found).name, 0), (top / "nowhere", "arch", 1)):
        process = call(["cmake", "-S", ROOT, "-B", top / f"by_variables_{status}", f"-DPETSC_DIR={folder}", f"-DPETSC_ARCH={arch}",
                        "-DTALUS_TESTS=OFF"], top)
        test.check(f"petsc_dir.{status}", process.returncode, status, status)
        test.check(f"petsc_dir.{status}.named", int((f"PETSC_DIR={folder}" in process.stderr) == bool(status)), 1, 1)


def tied(test, name, command, folder):
    """Each floor carries what acts on its block, the spring pulls at both alike, and both tops have gone."""
    words = must(test, name, command, folder).split()
    test.check(f"{name}_words", len(words), 7, 7)  # the one line: nothing else is printed, and no memory is left
    if len(words) == 7:
        push, pulled, pulls, first, second, moved, follows = map(float, words)
        test.check(f"{name}_first_floor", abs(push + pulled + first) / push, upper=1e-6)
        test.check(f"{name}_second_floor", abs(pulls + second) / push, upper=1e-6)
        test.check(f"{name}_spring", abs(pulled + pulls) / push, upper=1e-4)
        test.check(f"{name}_share", pulls / push, 0.05, 0.2)
        test.check(f"{name}_moved", min(moved, follows), 1e-3, 0.1)


def jacobians(test, name, command, folder):
    """All forms agree, and with finite differences, for law and physics of the plugin in 2D and 3D."""
    lines = [line.split() for line in must(test, name, command, folder).splitlines()]
    test.check(f"{name}_cases", len(lines), 50, 50)
    for case, _, *distances, differences in lines:
        for form, distance in zip(FORMS, distances):
            test.check(f"{name}_{case}_{form}", float(distance), upper=1e-14)
        test.check(f"{name}_{case}_differences", float(differences), upper=1e-7)


def laws(test, talus, folder):
    """The conformance tests on the law of the plugin, and on what is none."""
    output = must(test, "check_law", [talus, "check-law", "toys.so", "fung"], folder)
    test.check("check_law_suites", output.count("100%: Checks: "), 2, 2)
    for words, message in ((("toys.so", "gum"), "check-law toys.so: has no law gum"), (("toys.so",), "check-law: a plugin and")):
        process = call([talus, "check-law", *words], folder)
        test.check(f"check_law_{len(words)}_status", process.returncode, 2, 2)
        test.check(f"check_law_{len(words)}_message", int(message in process.stderr and process.stderr.count("\n") == 1), 1, 1)


def springs(test, talus, copy, plugin):
    """A block on springs k + h d^2 under its weight f: k d + h d^3 = f at rest; with inertia, Newmark's own angle a step."""
    def run(ranks, **options):
        run = Run(talus, copy / "springs.yaml", ranks, {"mpm_plugin": plugin, **options}, test.folder())
        test.check("springs_status", run.status, 0, 0)
        return run.results

    k, h, f, density = 1e5, 2e6, 2e4, 2e3
    for ranks in (1, 3):
        rest = run(ranks, mpm_term_left_stiffening=h, mpm_term_right_stiffening=h)
        d = -rest.column("track_t_uy")[-1]
        test.near(f"springs_{ranks}_ranks_at_rest", k * d + h * d ** 3, f, relative=1e-10)
        test.check(f"springs_{ranks}_ranks_aside", abs(rest.column("track_t_ux")[-1]), upper=1e-12)
    dt = 0.01
    moving = run(1, mpm_time_integrator="newmark", mpm_time_step=dt, mpm_time_end=1.2)
    square = k / density * dt * dt / 4
    angle = math.acos((1 - square) / (1 + square))
    error = max(abs(u + f / k * (1 - math.cos(angle * (n + 1)))) for n, u in enumerate(moving.column("track_t_uy")))
    test.check("springs_oscillation", error, upper=1e-10)
    balance = max(abs(moving.column("energy_balance"))) / max(moving.column("energy_kinetic"))
    test.check("springs_energy_balance", balance, upper=1e-10)
    for options, message in SPRING_FAULTS:
        process = call([talus, "-options_file", copy / "springs.yaml", "-mpm_plugin", plugin, *options], test.folder())
        test.check(f"{options[0]}_status", process.returncode, 2, 2)
        test.check(f"{options[0]}_message", int(message in process.stderr and process.stderr.count("\n") == 1), 1, 1)


def added(test, folder, copy):
    """The rows of three programs: what they give follows from the results, on any number of ranks."""
    def run(program, ranks, place=None, **options):
        run = Run(folder / program, copy / "pushed.yaml", ranks, options, place or test.folder())
        test.check(f"{program}_{ranks}_ranks_status", run.status, 0, 0)
        return run

    for ranks in (1, 3):
        results = run("mises", ranks, mpm_output_fields="stress,mises").results
        state = results.state("last")
        xx, yy, zz, xy = state["stress"].T[:4]
        mises = np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3 * xy ** 2)
        test.check(f"mises_{ranks}_ranks", max(abs(state["mises"].ravel() / mises - 1)), upper=1e-12)
        test.check(f"mises_{ranks}_ranks_in_the_index", int('"mises"' in Path(results.prefix + ".xdmf").read_text()), 1, 1)

        results = run("centre", ranks).results
        state, start = results.state("last"), results.state("first")
        centre = state["mass"].ravel() @ state["position"] / state["mass"].sum()
        longest = np.sqrt(((state["position"] - start["position0"]) ** 2).sum(axis=1)).max()
        for name, value in (("centre_x", centre[0]), ("centre_y", centre[1]), ("longest", longest)):
            test.near(f"{name}_{ranks}_ranks", results.column(name)[-1], value, relative=1e-12)

    whole = run("impulse", 1)
    time, step = whole.results.column("time"), whole.results.column("dt")
    for axis, component in enumerate("xy"):
        sum_of = step @ whole.results.column(f"reaction_floor_{component}")
        test.near(f"impulse_{component}", float(whole.output.split()[axis]), sum_of, relative=1e-12)
    for first, then in ((1, 1), (2, 3)):
        place = test.folder()
        run("impulse", first, place, mpm_time_end=0.5, mpm_checkpoint_every=5)
        on = run("impulse", then, place, mpm_restart="latest", mpm_checkpoint_every=5).output.split()
        for name, value, of_whole in zip(("x", "y", "time", "steps"), on, whole.output.split()):
            test.near(f"impulse_{first}_ranks_then_{then}_{name}", float(value), float(of_whole), relative=1e-9)
    test.check("impulse_steps", int(whole.output.split()[3]), len(time), len(time))


def paraboloid(test, talus, copy, plugin):
    """Where contact is narrow beside the radius, forces are a sphere's, to the square of their ratio; a load is carried."""
    pushed, loaded = {"motion": "0,-0.01"}, {"free": "y", "load": "0,-8e3"}
    shapes = {"paraboloid": {"tip": 0.8}, "sphere": {"center": "0,4.8"}}
    solid = {"mpm_dim": 3, "mpm_grid_lower": "-1,-1,0", "mpm_grid_upper": "1,1,1.2", "mpm_grid_cells": "10,10,6",
             "mpm_body_b_lower": "-0.8,-0.8,0", "mpm_body_b_upper": "0.8,0.8,0.8", "mpm_body_b_points_per_cell": "2,2,2",
             "mpm_bc_floor_lower": "-1,-1,0", "mpm_bc_floor_upper": "1,1,0", "mpm_bc_floor_components": "x,y,z"}

    def force(shape, ranks, way, dim=2):
        own = {"type": shape, **shapes[shape], **way}
        if dim == 3:
            own.update({"motion": "0,0,-0.01"} if shape == "paraboloid" else {"motion": "0,0,-0.01", "center": "0,0,4.8"})
        options = {f"mpm_boundary_die_{name}": value for name, value in own.items()}
        run = Run(talus, copy / "die.yaml", ranks, {"mpm_plugin": plugin, **options, **(solid if dim == 3 else {})},
                  test.folder())
        test.check(f"die_{shape}_status", run.status, 0, 0)
        return run.results.column(f"reaction_die_{'xyz'[dim - 1]}")[-1]

    one = force("paraboloid", 1, pushed)
    test.near("die_as_sphere", one, force("sphere", 1, pushed), relative=1e-3)
    test.near("die_3d_as_sphere", force("paraboloid", 1, pushed, 3), force("sphere", 1, pushed, 3), relative=1e-3)
    test.near("die_3_ranks", force("paraboloid", 3, pushed), one, relative=1e-8)
    test.near("die_at_rest", force("paraboloid", 1, loaded), -8e3, relative=1e-8)
    for options, message in DIE_FAULTS:
        process = call([talus, "-options_file", copy / "die.yaml", "-mpm_plugin", plugin, *options], test.folder())
        test.check(f"{options[1]}_status", process.returncode, 2, 2)
        test.check(f"{options[1]}_message", int(message in process.stderr and process.stderr.count("\n") == 1), 1, 1)


def main():
    build = Path(sys.argv[1]).resolve().parent
    with Test() as test:
        top = test.folder()
        prefix, folder, copy = top / "a prefix", top / "build", top / "sources"
        shutil.copytree(SOURCES, copy)  # outside the tree, so that nothing is found by accident
        install(test, build, prefix)
        must(test, "configure", ["cmake", "-S", copy, "-B", folder, f"-DCMAKE_PREFIX_PATH={prefix}"], top)
        must(test, "build", ["cmake", "--build", folder, "-j2"], top)
        with_pkg_config(test, prefix, folder)
        petsc_by_variables(test, top)
        ENVIRONMENT["LD_LIBRARY_PATH"] = str(prefix / "lib")
        for program in ("tied", "tied_static", "tied_pc"):
            tied(test, program, [folder / program, folder / "toys.so", "-malloc_dump"], folder)
        tied(test, "tied_ranks", ["mpiexec", "--oversubscribe", "-n", "2", folder / "tied", "toys.so"], folder)
        jacobians(test, "jacobians", [folder / "jacobians", "toys.so", "-malloc_dump"], folder)
        jacobians(test, "jacobians_ranks", ["mpiexec", "--oversubscribe", "-n", "2", folder / "jacobians", "toys.so"],
                  folder)
        laws(test, prefix / "bin" / "talus", folder)
        springs(test, prefix / "bin" / "talus", copy, folder / "toys.so")
        added(test, folder, copy)
        paraboloid(test, prefix / "bin" / "talus", copy, folder / "toys.so")
        for file, message in PLUGIN_FAULTS.items():
            process = call([prefix / "bin" / "talus", "-mpm_plugin", file, "-mpm_dim", "2"], copy)
            test.check(f"{file}_status", process.returncode, 2, 2)
            test.check(f"{file}_message", int(message in process.stderr and process.stderr.count("\n") == 1), 1, 1)
        manual = must(test, "manual", [prefix / "bin" / "talus", "-mpm_plugin", folder / "toys.so", "-help"], folder)
        test.check("manual_lists_the_law", int("Material of type fung" in manual), 1, 1)
        test.check("manual_lists_the_term", int("Term of type foundation" in manual), 1, 1)
        test.check("manual_lists_the_body", int("Boundary of type paraboloid" in manual), 1, 1)


if __name__ == "__main__":
    sys.exit(main())
