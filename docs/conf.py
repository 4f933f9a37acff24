"""Sphinx: the user guide in Markdown, the interface from docstrings; `make docs` builds it without warnings."""

project = "lodbench"
copyright = "the lodbench developers"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
html_theme = "furo"
html_title = "lodbench"
exclude_patterns = ["_build", "driver_defect/*.py"]
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
napoleon_numpy_docstring = False
myst_heading_anchors = 3
suppress_warnings = ["myst.xref_missing"]
