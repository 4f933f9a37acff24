"""Sphinx: the user guide in Markdown, the interface from docstrings; `make docs` builds it without warnings."""

from docutils import nodes
from latex2mathml.converter import convert

project = "lodbench"
copyright = "the lodbench developers"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
html_theme = "furo"
html_title = "lodbench"
html_math_renderer = "mathml"
exclude_patterns = ["_build"]
myst_enable_extensions = ["dollarmath"]
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
napoleon_numpy_docstring = False
myst_heading_anchors = 3
suppress_warnings = ["myst.xref_missing"]


def plain_blocks(app, what, name, obj, options, lines):
    """Fenced blocks of docstrings as literal blocks, and `**` as itself."""
    fenced, found = False, []
    for line in lines:
        if line.strip().startswith("```"):
            fenced = not fenced
            found += ["::", ""] if fenced else [""]
        else:
            found.append(f"    {line}" if fenced else line.replace("**", r"\*\*"))
    lines[:] = found


def formula(self, node, display):
    """A formula as MathML, which browsers show by themselves: nothing is loaded from elsewhere."""
    self.body.append(convert(node.astext(), display=display))
    raise nodes.SkipNode


def setup(app):
    """Called by Sphinx."""
    app.connect("autodoc-process-docstring", plain_blocks)
    app.add_html_math_renderer(
        "mathml",
        (lambda self, node: formula(self, node, "inline"), None),
        (lambda self, node: formula(self, node, "block"), None),
    )
