#!/usr/bin/env python3
"""The site of documents builds without a warning, and the theory covers what the program offers.

scripts/make_site.py builds it with Sphinx from docs/, the examples and `talus -help=json`; links that lead nowhere are found in its
pages, and in a small site with faults put in. Words of -help=json (COVERED) stand in docs/theory.md, whose files and pages exist;
every law has its section in docs/material.md, with equations and a source.

With --full in the site's own theme, which takes twice as long.

Quick.
"""
import json
import re
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import FULL, ROOT, Test, call  # noqa: E402
import make_site  # noqa: E402  (of scripts/)

# Options whose words theory.md has, each in backquotes
COVERED = ("kinematics", "shape", "shape_edge", "material_NAME_type", "contact_NAME_method", "bc_NAME_quantity",
           "bc_NAME_region", "boundary_NAME_type", "load_NAME_type", "time_integrator", "time_transfer", "time_mass", "stage_NAME_type",
           "stage_NAME_geostatic_method", "solver")
# Lists of a scene and groups of options that theory.md has, by their names
GROUPS = ("stabilization_", "materials", "surfaces", "boundaries", "contacts", "motions", "sections", "terms")
PICTURE_BYTES = 150000


def check_site(test):
    """Builds the site; every example is in its gallery, every option in its reference."""
    folder = test.folder()
    theme = "furo" if FULL else "basic"
    built = call([sys.executable, ROOT / "scripts" / "make_site.py", test.program, folder, theme], folder)
    test.check("site.status", built.returncode, 0, 0)
    print(built.stdout, built.stderr)
    if built.returncode:
        return
    html = folder / "html"
    gallery, index = ((html / name).read_text(encoding="utf-8") for name in ("gallery.html", "index.html"))
    for place in ROOT.glob("examples/*/README.md"):
        test.check(f"gallery.{place.parent.name}", f"examples/{place.parent.name}/README.html" in gallery, 1, 1)
    listed = (html / "docs" / "options.html").read_text(encoding="utf-8")
    laws = (html / "docs" / "options-materials.html").read_text(encoding="utf-8")
    for page, option in ((listed, "-mpm_grid_cells"), (listed, "-mpm_boundary_NAME_friction"), (laws, "-mpm_material_NAME_friction")):
        test.check(f"reference.{option}", option in page, 1, 1)
    test.check("formulas", (html / "docs" / "theory-formulation.html").read_text(encoding="utf-8").count("<math"), 20, None)
    for place in (ROOT / "docs").glob("*.md"):
        test.check(f"contents.{place.stem}", place.stem == "README" or f"docs/{place.stem}.html" in index, 1, 1)
    test.check("elsewhere", sum("<script src=\"http" in place.read_text(encoding="utf-8") for place in html.rglob("*.html")), 0, 0)
    test.check("pictures", max(place.stat().st_size for place in (html / "_images").glob("*.png")), None, PICTURE_BYTES)


def check_links(test):
    """Links to nowhere are found, others are not."""
    folder = test.folder()
    (folder / "a.html").write_text('<p id="here"><a href="b.html#there">x</a><a href="#here">y</a><a href="https://a.b/c">z</a></p>',
                                   encoding="utf-8")
    (folder / "b.html").write_text('<p id="there"></p>', encoding="utf-8")
    test.check("links.none", len(list(make_site.broken_links(folder))), 0, 0)
    (folder / "c.html").write_text('<a href="d.html">x</a><a href="b.html#nowhere">y</a><img src="e.png">', encoding="utf-8")
    test.check("links.broken", len(list(make_site.broken_links(folder))), 3, 3)


def check_theory(test):
    """theory.md has every word that the program lists, and names files that are there."""
    said = subprocess.run([test.program, "-help=json"], check=True, capture_output=True, text=True).stdout
    options = {option["option"].removeprefix("mpm_"): option for option in json.loads(said)}
    page = (ROOT / "docs" / "theory.md").read_text(encoding="utf-8")
    words = set(re.findall(r"`([^`]+)`", page))
    for name in COVERED:
        for word in options[name]["choices"]:
            test.check(f"theory.{name}.{word}", word in words, 1, 1)
    for word in {word for option in options.values() for word in option["physics"]}:
        test.check(f"theory.physics.{word}", word in words, 1, 1)
    for group in GROUPS:
        names = [name.removeprefix(group) if group.endswith("_") else name for name in options
                 if name.startswith(group) and (group.endswith("_") or name == group)]
        test.check(f"theory.{group}", len(names), 1)
        for name in names:
            test.check(f"theory.{group}.{name}", name in words, 1, 1)
    for word in words:
        if "/" in word:
            test.check(f"theory.file.{word}", (ROOT / word).is_file(), 1, 1)


def check_laws(test):
    """Every law has a section with equations and sources."""
    page = (ROOT / "docs" / "material.md").read_text(encoding="utf-8")
    sections = dict(re.findall(r"^## `(\w+)`\n(.*?)(?=^## |\Z)", page, re.MULTILINE | re.DOTALL))
    laws = {place.stem for place in (ROOT / "materials").glob("*.c")}
    test.check("laws.sections", sorted(sections) == sorted(laws), 1, 1)
    for law, text in sections.items():
        test.check(f"laws.{law}.equation", len(re.findall(r"^    \S.*=", text, re.MULTILINE)), 1)
        test.check(f"laws.{law}.source", len(re.findall(r"^Sources?:", text, re.MULTILINE)), 1)


def check_lists(test):
    """Lists written by hand have all that there is: examples, folders of the sources, notebooks and pages."""
    listed = (ROOT / "examples" / "README.md").read_text(encoding="utf-8")
    for place in ROOT.glob("examples/*/README.md"):
        test.check(f"examples.{place.parent.name}", f"({place.parent.name}/README.md)" in listed, 1, 1)
    folders = re.findall(r"`(\w+)`", (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8").partition("other folders")[0])
    for place in (ROOT / "src").iterdir():
        if any(place.glob("*.[ch]")):
            test.check(f"architecture.{place.name}", place.name in folders, 1, 1)
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    for place in (ROOT / "docs").glob("*.ipynb"):
        test.check(f"contents.{place.name}", f"({place.name})" in index, 1, 1)
    test.check("readme.lines", len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()), None, 100)


def main():
    with Test() as test:
        check_lists(test)
        check_links(test)
        check_theory(test)
        check_laws(test)
        check_site(test)


if __name__ == "__main__":
    main()
