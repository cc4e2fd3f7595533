"""An installed Talus is all that a program or a plugin needs.

Installs into an empty prefix, and builds tests/installed/ against that alone, once through find_package() and once through
pkg-config: a program in which two models exchange loads through hooks, with the shared library and with the static one,
and a plugin with a law and a physics of two fields, whose Jacobian must be the same in all forms.

Quick.
"""
import shutil
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ENVIRONMENT, ROOT, Test, call, must  # noqa: E402

SOURCES = ROOT / "tests" / "installed"
FORMS = ("coloring", "dense", "matfree", "matfree_without_tangents")
PLUGIN_FAULTS = {"nowhere.so": "-mpm_plugin nowhere.so: cannot be loaded",
                 "tied.c": "-mpm_plugin tied.c: cannot be loaded"}


def install(test, build, prefix):
    """Installs the build tree, and looks that all is there and nothing else is."""
    must(test, "install", ["cmake", "--install", build, "--prefix", prefix], build)
    for file in ("bin/talus", "lib/libtalus.a", "lib/libtalus.so", "include/talus/talus.h", "include/talus/plugin.h",
                 "include/talus/point/law.h", "lib/cmake/Talus/TalusConfig.cmake", "lib/pkgconfig/talus.pc"):
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
    flags = must(test, "pkg_config", ["pkg-config", "--cflags", "--libs", "talus"], folder).split()
    must(test, "compile", ["cc", "-std=c11", SOURCES / "tied.c", "-o", "tied_pc", *flags], folder)


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
    test.check(f"{name}_cases", len(lines), 30, 30)
    for case, _, *distances, differences in lines:
        for form, distance in zip(FORMS, distances):
            test.check(f"{name}_{case}_{form}", float(distance), upper=1e-14)
        test.check(f"{name}_{case}_differences", float(differences), upper=1e-7)


def main():
    build = Path(sys.argv[1]).resolve().parent
    with Test() as test:
        top = test.folder()
        prefix, folder, copy = top / "prefix", top / "build", top / "sources"
        shutil.copytree(SOURCES, copy)  # outside the tree, so that nothing is found by accident
        install(test, build, prefix)
        must(test, "configure", ["cmake", "-S", copy, "-B", folder, f"-DCMAKE_PREFIX_PATH={prefix}"], top)
        must(test, "build", ["cmake", "--build", folder, "-j2"], top)
        with_pkg_config(test, prefix, folder)
        ENVIRONMENT["LD_LIBRARY_PATH"] = str(prefix / "lib")
        for program in ("tied", "tied_static", "tied_pc"):
            tied(test, program, [folder / program, folder / "toys.so", "-malloc_dump"], folder)
        tied(test, "tied_ranks", ["mpiexec", "--oversubscribe", "-n", "2", folder / "tied", "toys.so"], folder)
        jacobians(test, "jacobians", [folder / "jacobians", "toys.so", "-malloc_dump"], folder)
        jacobians(test, "jacobians_ranks", ["mpiexec", "--oversubscribe", "-n", "2", folder / "jacobians", "toys.so"],
                  folder)
        for file, message in PLUGIN_FAULTS.items():
            process = call([prefix / "bin" / "talus", "-mpm_plugin", file, "-mpm_dim", "2"], copy)
            test.check(f"{file}_status", process.returncode, 2, 2)
            test.check(f"{file}_message", int(message in process.stderr and process.stderr.count("\n") == 1), 1, 1)
        manual = must(test, "manual", [prefix / "bin" / "talus", "-mpm_plugin", folder / "toys.so", "-help"], folder)
        test.check("manual_lists_the_law", int("Material of type fung" in manual), 1, 1)


if __name__ == "__main__":
    sys.exit(main())
