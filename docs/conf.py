"""Configuration of Sphinx for the site, whose pages scripts/make_site.py prepares. Formulas become MathML, so that pages load nothing
from elsewhere."""
from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

project = "Talus"
author = copyright = "Talus developers"  # noqa: A001
extensions = ["myst_parser"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
html_theme = "furo"
html_title = "Talus"
html_copy_source = False
html_show_copyright = False
pygments_style = "friendly"
smartquotes = False
suppress_warnings = ["myst.header"]  # of examples that begin with a smaller heading


def write_formula(translator, node):
    translator.body.append(tex2mathml(node.astext(), inline=True))
    raise nodes.SkipNode


def write_equation(translator, node):
    translator.body.append(f'<div style="overflow-x: auto; padding: 0.4em 0">{tex2mathml(node.astext(), inline=False)}</div>\n')
    raise nodes.SkipNode


def setup(app):
    app.add_node(nodes.math, override=True, html=(write_formula, None))
    app.add_node(nodes.math_block, override=True, html=(write_equation, None))
    return {"parallel_read_safe": True}
