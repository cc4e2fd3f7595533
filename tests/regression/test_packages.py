#!/usr/bin/env python3
"""Packages as those use them who have no part in the tree: the Debian package and the wheel.

The Debian package is made from the build, looked over by lintian where that is installed, installed below a folder with a
blank in its name, and removed again; what it depends on is what is installed here. A user who may write nothing there runs
its examples in his own folder and from a pipe, with German numbers, on one rank and on two, and from Python with the wheel.
Without root the user is oneself, and the package is unpacked only. Without a package index there is no wheel.
"""
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ENVIRONMENT, ROOT, Test, call, must  # noqa: E402

NOBODY = 65534
AS_ROOT = os.geteuid() == 0
NO_INDEX = ("Could not find a version", "No matching distribution", "Connection", "Temporary failure in name resolution")
STEPS = ("-mpm_time_end", "0.04", "-mpm_output_every", "0")
FROM_PYTHON = """
import locale, sys, talus
locale.setlocale(locale.LC_ALL, "")
run = talus.run(sys.argv[1], folder=sys.argv[2], time_end=0.04)
print(run.history["track_tip_uy"].iloc[1])
"""


class User:
    """Who runs the package, in a folder of his own."""

    def __init__(self, folder, root, locales):
        self.folder = folder
        self.environment = {**ENVIRONMENT, "PATH": f"{root}/usr/bin:{os.environ['PATH']}", "HOME": str(folder), "LOCPATH": str(locales),
                            "LC_ALL": "de_DE.UTF-8", "TMPDIR": str(folder)}
        if AS_ROOT:
            os.chown(folder, NOBODY, NOBODY)

    def run(self, *command, ranks=1, **more):
        """A command with its words, on one rank or by mpiexec."""
        words = ["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups"] if AS_ROOT else []
        words += ["mpiexec", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
        own = {"OMPI_MCA_ess_singleton_isolated": "1"} if ranks == 1 else {}
        return subprocess.run([*words, *map(str, command)], cwd=self.folder, env={**self.environment, **own}, text=True,
                              capture_output=True, check=False, **more)


def make_package(test, build, place):
    """The Debian package with the program, made from the build as it stands: for Ninja cpack does not look through all targets again."""
    must(test, "cpack", ["cpack", "-G", "DEB", "--config", build / "CPackConfig.cmake", "-B", place,
                         "-D", "CPACK_COMPONENTS_ALL=program;documents", "-D", "CPACK_CMAKE_GENERATOR=Ninja"], place)
    package, = place.glob("talus_*.deb")
    if shutil.which("lintian"):
        process = call(["lintian", "--allow-root", "--fail-on", "error,warning", package], place)
        test.check("lintian", process.returncode, 0, 0)
        print(process.stdout, process.stderr)
    needed = call(["dpkg-deb", "-f", package, "Depends"], place).stdout
    for alternatives in needed.strip().split(", "):
        names = [name.split()[0] for name in alternatives.split(" | ")]
        states = [call(["dpkg-query", "-W", "-f=${db:Status-Status}", name], place).stdout for name in names]
        test.check(f"depends.{names[0]}", int("installed" in states), 1, 1)
    test.check("depends.petsc", int("libpetsc" in needed and "libhdf5" in needed), 1, 1)
    return package


def dpkg(test, root, *words):
    """Debian's installer, below a root of its own."""
    for folder in ("info", "updates", "triggers"):
        (root / "var/lib/dpkg" / folder).mkdir(parents=True, exist_ok=True)
    (root / "var/lib/dpkg/status").touch()
    must(test, words[0], ["dpkg", f"--root={root}", "--force-depends", *words], root)


def check_files(test, root):
    """Nothing of the tree is named; pages and schema are there."""
    for file in ("usr/share/man/man1/talus.1.gz", "usr/share/bash-completion/completions/talus", "usr/share/zsh/site-functions/_talus",
                 "usr/share/talus/talus.schema.json", "usr/share/doc/talus/copyright", "usr/share/doc/talus/docs/first-run.md",
                 "usr/share/doc/talus/examples/cantilever/case.yaml", "usr/share/doc/talus/scripts/plot.py"):
        test.check(file, int((root / file).exists()), 1, 1)
    named = [file for file in (root / "usr").rglob("*") if file.is_file() and str(ROOT).encode() in file.read_bytes()]
    test.check("files_that_name_the_tree", len(named), 0, 0)
    print(*named)


def check_recipes(test, root):
    """Files for Docker, Spack and modules, as far as that goes without these: form, and names that exist."""
    packaging = ROOT / "packaging"
    text = (packaging / "docker/Dockerfile").read_text(encoding="utf-8").replace("\\\n", " ")
    lines = [line.split() for line in text.splitlines() if line and not line.startswith("#")]
    words = {"FROM", "COPY", "WORKDIR", "RUN", "USER", "ENV", "ENTRYPOINT"}
    test.check("docker.words", len({line[0] for line in lines} - words), 0, 0)
    test.check("docker.scripts", int(all((ROOT / name).exists() for name in re.findall(r"\./(scripts/\S+)", text))), 1, 1)
    recipe = (packaging / "spack/package.py").read_text(encoding="utf-8")
    compile(recipe, "package.py", "exec")
    options = set(re.findall(r'define(?:_from_variant)?\("(\w+)"', recipe))
    known = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    test.check("spack.options", len([name for name in options if name not in known]) if options else 1, 0, 0)
    module = (packaging / "modulefiles/talus").read_text(encoding="utf-8")
    folders = re.findall(r"^prepend-path \w+ +\$prefix/(\S+)", module, re.MULTILINE)
    there = [folder for folder in folders if folder.startswith("lib") or (root / "usr" / folder).is_dir()]
    test.check("module.folders", len(there) if module.startswith("#%Module") else 0, len(folders), len(folders))


def check_runs(test, user, scene):
    """Runs of an example that stands where the user may not write; its history, by the check of the example's folder."""
    version = user.run("talus", "--version")
    test.check("version", int(version.returncode == 0 and version.stdout.startswith("talus ")), 1, 1)
    run = user.run("talus", scene, *STEPS, "-mpm_output_prefix", "own folder/run")
    test.check("status", run.returncode, 0, 0)
    print(run.stderr)
    text = (user.folder / "own folder/run_history.csv").read_text(encoding="utf-8")
    test.check("numbers_with_points", int(re.fullmatch(r"[-+.0-9e]+(,[-+.0-9e]+)*", text.splitlines()[-1]) is not None), 1, 1)
    by_ranks = user.run("talus", scene, *STEPS, "-mpm_output_prefix", "two", ranks=2)
    test.check("two_ranks", by_ranks.returncode, 0, 0)
    with open(scene, encoding="utf-8") as file:
        piped = user.run("talus", "-", *STEPS, "-mpm_output_prefix", "piped", stdin=file)
    test.check("pipe", piped.returncode, 0, 0)
    test.check("pipe_history", int((user.folder / "piped_history.csv").read_text(encoding="utf-8") == text), 1, 1)
    head = user.run("bash", "-c", 'talus - < "$0" -mpm_time_end 0.02 -mpm_output_prefix head | head -n 1', scene)
    test.check("head", int(head.returncode == 0 and head.stdout.count("\n") == 1 and not head.stderr), 1, 1)
    if AS_ROOT:
        refused = user.run("talus", scene, *STEPS, "-mpm_output_prefix", scene.parent / "run")
        test.check("write_protected", refused.returncode, 2, 2)
        test.check("write_protected_line", int("its folder" in refused.stderr and refused.stderr.count("\n") == 1), 1, 1)
    checked = user.run(sys.executable, scene.parent / "check.py", "own folder/run")
    test.check("check_runs", int("completed 1" in checked.stdout), 1, 1)
    print(checked.stderr)


def make_wheel(test, place):
    """The wheel, in a virtual environment; its Python, or None without a package index."""
    made = call([sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--retries", "1", "--wheel-dir", place, ROOT / "python"], place)
    if made.returncode and any(text in made.stderr for text in NO_INDEX):
        print("no package index: there is no wheel")
        return None
    test.check("wheel", made.returncode, 0, 0)
    print(made.stderr)
    wheel, = place.glob("talus-*.whl")
    must(test, "venv", [sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", place / "venv"], place)
    python = place / "venv/bin/python"
    must(test, "wheel_installs", [sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-deps", "--no-index", wheel], place)
    return python


def check_python(test, user, python, scene):
    """A run from Python by the installed program."""
    run = user.run(python, "-c", FROM_PYTHON, scene, user.folder / "from python")
    test.check("python", run.returncode, 0, 0)
    print(run.stderr)


def main():
    with Test() as test:
        build = test.program.parent
        top = test.folder()
        for folder in (top.parent, top):
            folder.chmod(0o755)
        root, packages, locales, own = (top / name for name in ("for all users", "packages", "locales", "own"))
        for folder in (root, packages, locales, own):
            folder.mkdir()
        must(test, "localedef", ["localedef", "-i", "de_DE", "-f", "UTF-8", locales / "de_DE.UTF-8"], top)
        package = make_package(test, build, packages)
        if AS_ROOT:
            dpkg(test, root, "--install", package)
        else:
            must(test, "unpack", ["dpkg-deb", "-x", package, root], top)
        check_files(test, root)
        check_recipes(test, root)
        user = User(own, root, locales)
        scene = root / "usr/share/doc/talus/examples/cantilever/case.yaml"
        check_runs(test, user, scene)
        python = make_wheel(test, packages)
        if python:
            check_python(test, user, python, scene)
        if AS_ROOT:
            dpkg(test, root, "--remove", "talus")
            left = [file for file in (root / "usr").rglob("*") if file.is_file()] if (root / "usr").exists() else []
            test.check("left_after_removal", len(left), 0, 0)


if __name__ == "__main__":
    sys.exit(main())
