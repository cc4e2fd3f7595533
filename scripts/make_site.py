#!/usr/bin/env python3
"""Builds the site of documents with Sphinx: scripts/make_site.py [PROGRAM [FOLDER [THEME]]].

By default build/talus, build/site and furo. With the theme basic, for a check, notebooks are not run and pages made in half the time.

FOLDER/source gets what the site is made of, FOLDER/html the site. Sources are the pages of PAGES with what they link to, and pages
that are made here: a front page from docs/README.md, whose sections become the contents; the reference of options from `talus
-help=json`; the gallery from the examples' first paragraphs and pictures; notebooks. A warning of Sphinx is an error, and so is a
link to a page, a heading or a file that is not there.
"""
import base64
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
PAGES = ("docs/*.md", "docs/*.ipynb", "examples/*/README.md", "materials/README.md", "physics/README.md",
         "tests/README.md", "scripts/bench/README.md", "CONTRIBUTING.md", "CHANGELOG.md")
LINK = re.compile(r"(!?)\[((?:[^\[\]]|!\[[^\]]*\]\([^)]*\)|\[[^\]]*\])*)\]\(([^)\s]+)\)")
FENCE = re.compile(r"(^```.*?^```$)", re.MULTILINE | re.DOTALL)
PICTURE_WIDTH, PICTURE_BYTES = 1200, 150000


# ---- pages ----

def first_heading(text):
    return re.search(r"^# (.+)$", text, re.MULTILINE).group(1)


def is_elsewhere(target):
    return re.match(r"[a-z]+:", target) is not None


def write_picture(source, target):
    """A picture of at most PICTURE_WIDTH pixels and PICTURE_BYTES bytes."""
    target.parent.mkdir(parents=True, exist_ok=True)
    if source.suffix != ".png" or source.stat().st_size < PICTURE_BYTES:
        shutil.copy(source, target)
        return
    picture = Image.open(source).convert("RGB")
    for width in (1, 2, 3):
        picture.thumbnail((PICTURE_WIDTH // width, 10 * PICTURE_WIDTH))
        picture.quantize(64, method=Image.Quantize.FASTOCTREE).save(target)
        if target.stat().st_size < PICTURE_BYTES:
            return


def settle_links(text, page, source, pages):
    """The page's text with links as the site has them; copies the files that it links to."""
    def settle(match):
        picture, label, target = match.groups()
        label = LINK.sub(settle, label)
        path, _, anchor = target.partition("#")
        if is_elsewhere(target) or not path:
            return f"{picture}[{label}]({target})"
        name = Path(os.path.normpath(page.parent / path))
        place = ROOT / name
        if (source / name).exists() and not place.exists():  # made for the site
            return match.group()
        if name not in pages and not place.exists():
            sys.exit(f"site: {page}: no such file: {target}")
        if name == Path("docs/README.md"):
            return f"[{label}]({relative(Path('index.md'), page)})"
        if name in pages and name != page:
            return f"{picture}[{label}]({target.replace('.ipynb', '.md')})"
        if place.is_dir() or name.suffix == ".md":
            return label
        (write_picture if picture else copy_file)(place, source / name)
        return f"![{label}]({path})" if picture else f"{{download}}`{label.replace('`', '')} <{path}>`"

    return "".join(part if part.startswith("```") else LINK.sub(settle, part) for part in FENCE.split(text))


def relative(target, page):
    return "/".join([".."] * len(page.parent.parts) + [str(target)])


def copy_file(place, target):
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(place, target)


def run_notebook(book, program):
    """Runs the cells of a notebook in a folder that is gone afterwards."""
    from nbclient import NotebookClient
    os.environ.update(TALUS=str(program), PYTHONPATH=str(ROOT / "python" / "src"), PYDEVD_DISABLE_FILE_VALIDATION="1")
    with tempfile.TemporaryDirectory() as folder:
        NotebookClient(book, timeout=600, kernel_name="python3", resources={"metadata": {"path": folder}}).execute()


def write_output(output, picture):
    """What a cell has printed, returned or drawn; a picture goes into a file."""
    data = output.get("data", {"text/plain": output.get("text", "")})
    if "image/png" in data:
        picture.parent.mkdir(parents=True, exist_ok=True)
        picture.write_bytes(base64.b64decode(data["image/png"]))
        return f"![Output of the cell above]({picture.name})"
    return f"```text\n{''.join(data.get('text/plain', ''))}\n```"


def notebook_text(place, target, program):
    """A notebook as a page: text as it is, code in blocks, and its outputs where there is a program to run it with."""
    import nbformat
    book, parts = nbformat.read(place, 4), []
    if program:
        run_notebook(book, program)
    for number, cell in enumerate(book.cells):
        parts.append(cell.source if cell.cell_type == "markdown" else f"```python\n{cell.source}\n```")
        parts += [write_output(output, target.with_name(f"{place.stem}-{number}-{k}.png"))
                  for k, output in enumerate(cell.get("outputs", ()))]
    return "\n\n".join(parts) + f"\n\nThe notebook itself: [{place.name}]({place.name})\n"


# ---- front page, gallery, reference ----

def contents(index):
    """(heading, [(page, label)]) of each section of docs/README.md."""
    for section in re.split(r"^## ", index, flags=re.MULTILINE)[1:]:
        links = re.findall(r"^\| \[([^\]]+)\]\(([^)#]+)\)", section, re.MULTILINE)
        yield section.split("\n", 1)[0], [(target, label) for label, target in links]


def move_links(text, folder):
    """The text of a page in a folder, for a page in the root."""
    def move(match):
        target = match.group(1)
        return f"]({target if is_elsewhere(target) else os.path.normpath(os.path.join(folder, target))})"

    return re.sub(r"\]\(([^)\s]+)\)", move, text)


def front_page(index):
    made = [("Gallery", "gallery.md"), ("Options", "docs/options.md"), ("Options of the laws", "docs/options-materials.md")]
    text = move_links(index, "docs") + "\n## Reference\n\n| page | |\n|---|---|\n"
    text += "".join(f"| [{label}]({page}) | made from this version |\n" for label, page in made)
    for heading, entries in [*contents(index), ("Reference", [(os.path.relpath(page, "docs"), label) for label, page in made])]:
        rows = "\n".join(f"{label} <{entry_page(target)}>" for target, label in entries)
        text += f"\n```{{toctree}}\n:hidden:\n:caption: {heading}\n\n{rows}\n```\n"
    return text


def entry_page(target):
    return "/" + os.path.normpath(Path("docs") / target).removesuffix(".md").removesuffix(".ipynb")


def paragraph(text):
    """The first paragraph below the first heading."""
    return re.split(r"\n\s*\n", text.split("\n", 1)[1].strip())[0]


def gallery():
    parts = ["# Gallery\n\nEvery example has equations, source, expected result and a check. Its page says how to run it.\n"]
    names = []
    for place in sorted(ROOT.glob("examples/*/README.md")):
        name, text = place.parent.name, place.read_text(encoding="utf-8")
        picture = re.search(r"!\[([^\]]*)\]\(([^)]+)\)", text)
        shown = f"[![{picture.group(1)}]({picture.group(2)})](README.md)\n" if picture else ""
        section = f"## [{first_heading(text)}](README.md)\n\n{paragraph(text)}\n\n{shown}"
        parts.append(move_links(section, f"examples/{name}"))
        names.append(f"examples/{name}/README")
    return "\n".join(parts) + "\n```{toctree}\n:hidden:\n\n" + "\n".join(names) + "\n```\n"


def cell(text):
    return str(text).replace("|", "\\|").replace("<", "\\<").replace("*", "\\*").replace("_", "\\_").replace("$", "\\$")


def bounds(option):
    """What values an option takes: words, or a range."""
    if option.get("choices"):
        return ", ".join(f"`{word}`" for word in option["choices"])
    lower = option.get("minimum", option.get("exclusiveMinimum"))
    upper = option.get("maximum", option.get("exclusiveMaximum"))
    rows = [f"{'at least' if 'minimum' in option else 'above'} {lower:g}" if lower is not None else "",
            f"{'at most' if 'maximum' in option else 'below'} {upper:g}" if upper is not None else ""]
    return ", ".join(row for row in rows if row)


def option_table(options):
    rows = ["| option | meaning |", "|---|---|"]
    for option in options:
        default = "required" if option["required"] else f"default {option['default']}" if option["default"] is not None else ""
        facts = "; ".join(fact for fact in (cell(option["unit"] or ""), bounds(option), cell(default)) if fact)
        rows.append(f"| `-{option['option']}` | {cell(option['help'])}{f' ({facts})' if facts else ''} |")
    return "\n".join(rows)


def reference(program):
    """Pages of all options, by the headings of the manual: of laws, and of everything else."""
    options = json.loads(subprocess.run([program, "-help=json"], check=True, capture_output=True, text=True).stdout)
    sections = {}
    for option in options:
        sections.setdefault(option["section"], []).append(option)
    laws = {name: rows for name, rows in sections.items() if name.startswith("Material of type")}
    others = {name: rows for name, rows in sections.items() if name not in laws}
    lead = ("\n\nFrom `talus -help=json` of this version. NAME is the name of a block, BLOCK its kind and name. In a scene "
            "`-mpm_grid_cells` is `mpm: grid: cells`. ")
    pages = {"docs/options.md": ("# Options", lead + "Parameters of laws have [a page of their own](options-materials.md).", others),
             "docs/options-materials.md": ("# Options of the laws", lead + "Equations are on the page [Materials](material.md).", laws)}
    for name, (heading, text, chosen) in pages.items():
        yield name, heading + text + "".join(f"\n\n## {title}\n\n{option_table(rows)}" for title, rows in chosen.items()) + "\n"


# ---- the site ----

def write_sources(program, source, with_outputs):
    """Writes all pages; returns their number."""
    pages = {path.relative_to(ROOT) for glob in PAGES for path in ROOT.glob(glob)} - {Path("docs/README.md")}
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    texts = {Path("index.md"): front_page(index), Path("gallery.md"): gallery(),
             **{Path(name): text for name, text in reference(program)}}
    pages |= set(texts)
    for page in pages - set(texts):
        place = ROOT / page
        texts[page] = (notebook_text(place, source / page, program if with_outputs else None) if page.suffix == ".ipynb"
                       else place.read_text(encoding="utf-8"))
    for page, text in texts.items():
        target = source / page.with_suffix(".md")
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(settle_links(text, page, source, pages).replace("```csv", "```text"), encoding="utf-8")
    shutil.copy(ROOT / "docs" / "conf.py", source / "conf.py")
    return len(texts)


class Page(HTMLParser):
    """Anchors, links and pictures of a page."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.links = set(), []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.anchors |= {values[key] for key in ("id", "name") if values.get(key)}
        self.links += [values[key] for key in ("href", "src") if values.get(key)]


def broken_links(html):
    """(page, link) of each link within the site that leads nowhere."""
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in html.rglob("*.html")}
    for path, page in pages.items():
        for link in page.links:
            target, _, anchor = link.partition("#")
            if is_elsewhere(link) or link.startswith("//"):
                continue
            place = (path.parent / unquote(target.partition("?")[0])).resolve() if target else path
            if not place.exists() or (anchor and place in pages and unquote(anchor) not in pages[place].anchors):
                yield path.relative_to(html), link


def main():
    program, folder, theme = sys.argv[1:] + ["build/talus", "build/site", "furo"][len(sys.argv) - 1:]
    source, html = Path(folder) / "source", Path(folder) / "html"
    for place in (source, html):
        shutil.rmtree(place, ignore_errors=True)
    count = write_sources(Path(program).resolve(), source, theme == "furo")
    built = subprocess.run([sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-D", f"html_theme={theme}", "-b", "html",
                            "-d", str(Path(folder) / "trees"), str(source), str(html)], check=False)
    if built.returncode:
        sys.exit("site: Sphinx has warned")
    broken = list(broken_links(html))
    for page, link in broken:
        print(f"site: {page}: link to nowhere: {link}", file=sys.stderr)
    if broken:
        sys.exit(1)
    print(f"site: {count} pages in {html}")


if __name__ == "__main__":
    main()
