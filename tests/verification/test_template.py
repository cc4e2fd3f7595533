"""A constitutive law is one file, and the template is the first: a copy under another name runs in a scene.

The template of materials/README.md, linear_elastic.c with its name replaced, is added to a copy of the sources, where the
build finds it: it is configured, and what depends on the file is compiled and put before the library that is there. The same
file becomes a plugin of an installed Talus. Both give the template's own results, to the last bit, in plane strain and in
3D, and -help lists the law.
"""
import re
import shutil
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ENVIRONMENT, ROOT, Results, Test, must  # noqa: E402

TEMPLATE, NAME = "linear_elastic", "my_law"
FOLDERS = ("cmake", "examples", "include", "materials", "options", "physics", "scripts", "src")
KEPT = ("CMAKE_BUILD_TYPE", "CMAKE_C_COMPILER", "TALUS_NATIVE", "TALUS_SANITIZE")
SCENE = """
mpm:
  dim: {dim}
  grid: {{lower: "{zero}", upper: "{one}", cells: "{cells}"}}
  materials: rock
  material_rock: {{type: {law}, E: 30e6, nu: 0.25, density: 2000}}
  bodies: block
  body_block: {{region: box, lower: "{zero}", upper: "{one}", material: rock}}
  bcs: base
  bc_base: {{region: box, lower: "{zero}", upper: "{base}", components: "{axes}"}}
  loads: weight
  load_weight: {{type: gravity, value: "{gravity}"}}
  time: {{end: 1, step: 0.5}}
  output: {{prefix: {law}_{dim}d, every: 1}}
"""
PLUGIN = f"""cmake_minimum_required(VERSION 3.20)
project(plugin LANGUAGES C)
set(CMAKE_BUILD_TYPE Release)
find_package(Talus REQUIRED)
talus_add_plugin(mine LAWS {NAME}.c)
"""


def write_scene(folder, dim, law):
    """Its path: a block on a fixed base under its weight."""
    path = folder / f"{law}_{dim}d.yaml"
    path.write_text(SCENE.format(dim=dim, law=law, zero=",".join("0" * dim), one=",".join("1" * dim),
                                 cells=",".join("3" * dim), base=",".join(["1", "0", "1"][:dim]),
                                 axes=",".join("xyz"[:dim]), gravity=",".join(["0", "-9.81", "0"][:dim])))
    return path


def write_law(path):
    """The template under the other name, as materials/README.md says it."""
    text = (ROOT / "materials" / f"{TEMPLATE}.c").read_text(encoding="utf-8")
    path.write_text(text.replace(TEMPLATE, NAME), encoding="utf-8")


def in_tree(test, build, top):
    """The program with one more file in materials/: only what depends on that is compiled."""
    sources, own = top / "sources", top / "own"
    for folder in FOLDERS:
        shutil.copytree(ROOT / folder, sources / folder, ignore=shutil.ignore_patterns("*.png", "__pycache__"))
    for name in ("CMakeLists.txt", "LICENSE"):
        shutil.copy(ROOT / name, sources)
    write_law(sources / "materials" / f"{NAME}.c")
    cache = dict(re.findall(r"^(\w+):\w+=(.*)$", (build / "CMakeCache.txt").read_text(), re.MULTILINE))
    must(test, "configure", ["cmake", "-G", "Unix Makefiles", "-S", sources, "-B", own, "-DTALUS_TESTS=OFF",
                             *(f"-D{key}={cache[key]}" for key in KEPT if cache.get(key))], top)
    for file in (f"materials/{NAME}", "src/point/registry", "src/run/main"):
        must(test, f"compile {file}", ["make", "-C", own, "-j2", f"{file}.o"], own)
    objects = [path for path in own.rglob("*.o") if path.name in (f"{NAME}.c.o", "registry.c.o")]
    test.check("instances", len([path for path in objects if path.name == f"{NAME}.c.o"]), 12, 12)
    link = (own / "CMakeFiles" / "talus.dir" / "link.txt").read_text().split()
    place = link.index("libtalus.a")
    must(test, "link", [*link[:place], *objects, build / "libtalus.a", *link[place + 1:]], own)
    return [own / "talus"]


def plugin(test, build, top):
    """An installed program, and the law as a plugin."""
    prefix, folder = top / "prefix", top / "plugin"
    folder.mkdir()
    write_law(folder / f"{NAME}.c")
    (folder / "CMakeLists.txt").write_text(PLUGIN)
    must(test, "install", ["cmake", "--install", build, "--prefix", prefix], build)
    must(test, "configure_plugin", ["cmake", "-S", folder, "-B", folder / "build", f"-DCMAKE_PREFIX_PATH={prefix}"], top)
    must(test, "build_plugin", ["cmake", "--build", folder / "build", "-j2"], top)
    ENVIRONMENT["LD_LIBRARY_PATH"] = str(prefix / "lib")
    return [prefix / "bin" / "talus", "-mpm_plugin", folder / "build" / "mine.so"]


def compare(test, name, program, folder):
    """Runs with the law and with the template; stress and position of all points, bit by bit."""
    for dim in (2, 3):
        tables = []
        for law in (NAME, TEMPLATE):
            must(test, f"{name}_{dim}d_{law}", [*program, "-options_file", write_scene(folder, dim, law), "-mpm_quiet"],
                 folder)
            tables.append(Results(str(folder / f"{law}_{dim}d")))
        for field in ("stress", "position"):
            mine, other = (results.state("last")[field] for results in tables)
            test.check(f"{name}_{dim}d_{field}", np.abs(mine - other).max(), 0, 0)
        test.check(f"{name}_{dim}d_loaded", np.abs(mine).max(), lower=1e-3)
    manual = must(test, f"{name}_manual", [*program, "-help"], folder)
    test.check(f"{name}_listed", int(f"Material of type {NAME}" in manual), 1, 1)


def main():
    build = Path(sys.argv[1]).resolve().parent
    with Test() as test:
        top = test.folder()
        for name, make in (("in_tree", in_tree), ("plugin", plugin)):
            folder = top / f"runs_{name}"
            folder.mkdir()
            compare(test, name, make(test, build, top), folder)


if __name__ == "__main__":
    sys.exit(main())
