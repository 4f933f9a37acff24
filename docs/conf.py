"""Sphinx: the user guide in Markdown, the interface from docstrings; `make docs` builds it without warnings."""

import json
import runpy
from collections import Counter
from pathlib import Path

from docutils import nodes
from latex2mathml.converter import convert

from lodbench.harness.record.record import read_run
from lodbench.harness.report.claims import verdicts

project = "lodbench"
copyright = "the lodbench developers"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
default_role = "code"
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


REFERENCE = Path(__file__).parents[1] / "results" / "reference"
PAPERS = {
    "gmr05": "Boubekeur & Schlick 2005",
    "gems3": "Boubekeur & Schlick 2007, GPU Gems 3",
    "dt07": "DeCoro & Tatarchuk 2007",
    "rc13": "Concheiro 2013",
    "w14": "Wang, Liu, Feng & Li",
}


def judged(app, page, source):
    """The verdicts of the committed runs, where the page on claims asks for them."""
    if page != "claims":
        return
    folders = sorted(REFERENCE.glob("*/*"))
    found = verdicts([read_run(folder) for folder in folders])
    counts = Counter(one["verdict"] for one in found)
    lines = [", ".join(f"{count} {word}" for word, count in counts.most_common()) + "."]
    for short, paper in PAPERS.items():
        lines += ["", f"## {paper}", ""]
        for one in found:
            if one["name"].startswith(f"{short}_"):
                reason = f" ({one['reason']})" if one["reason"] else ""
                lines.append(
                    f"- {one['claim'][0].upper()}{one['claim'][1:]}: **{one['verdict']}**{reason}"
                )
                told = ("published", "measured", "rule", "source")
                lines += [f"  - {key}: {one[key]}" for key in told if one[key]]
    source[0] = source[0].replace("VERDICTS", "\n".join(lines))


def measured(app, page, source):
    """What `compare` found, and how the tests went on each driver, where the page on measuring asks for them."""
    if page == "measuring":
        for word, tell in (("COMPARED", _compared), ("DRIVERS", _drivers)):
            path = REFERENCE / f"{'comparison' if word == 'COMPARED' else 'runtimes'}.json"
            told = tell(json.loads(path.read_text("utf-8"))) if path.exists() else "Not recorded."
            source[0] = source[0].replace(word, told)


def _compared(found):
    same, slower, worse = (found[key] for key in ("same", "slower", "worse"))
    times = "; ".join(slower["said"])
    return (
        f"The same code was compared {same['comparisons']} times, in processes of their own: {same['alarms']} alarms "
        f"({same['alarms_of_one_run']} before a second run was asked to confirm them), at a level of "
        f"{found['level']:.0%} for each comparison. A kernel that does an eighth of its items twice, so that the "
        f"frame takes about a tenth more time, was found {slower['found']} of {slower['tries']} times ({times}), with "
        f"{slower['others']} alarms on other rows; an error a tenth larger {worse['found']} of {worse['tries']} times, "
        f"with {worse['others']}. On {found['cpu']}, {found['driver']}, commit {found['commit']}"
        f"{', with changes not committed' if found['dirty'] else ''}."
    )


def _drivers(found):
    lines = ["| driver | passed | failed | skipped | commit |", "| --- | --- | --- | --- | --- |"]
    for name, one in found.items():
        skipped = sum(one["skipped"].values())
        lines.append(
            f"| {name} | {one['passed']:,} | {len(one['failed'])} | {skipped} | {one['commit']} |"
        )
    return "\n".join(lines)


def broken(app, page, source):
    """The record of faults as tables, where the page on them asks for it."""
    if page == "faults":
        tables = runpy.run_path(str(Path(__file__).with_name("faults.py")))["tables"]
        record = json.loads((REFERENCE / "faults.json").read_text("utf-8"))
        source[0] = source[0].replace("FIGURES", tables(record))


def formula(self, node, display):
    """A formula as MathML, which browsers show by themselves: nothing is loaded from elsewhere."""
    self.body.append(convert(node.astext(), display=display))
    raise nodes.SkipNode


def setup(app):
    """Called by Sphinx."""
    app.connect("autodoc-process-docstring", plain_blocks)
    app.connect("source-read", judged)
    app.connect("source-read", measured)
    app.connect("source-read", broken)
    app.add_html_math_renderer(
        "mathml",
        (lambda self, node: formula(self, node, "inline"), None),
        (lambda self, node: formula(self, node, "block"), None),
    )
