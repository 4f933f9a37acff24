import html.parser
import json
import re
import struct
import zlib

import pytest

from lodbench.harness.report import plots
from lodbench.harness.report.page import inline, write_report
from lodbench.harness.report.plots import documents
from lodbench.harness.report.table_view import columns, headlines, lines
from tests.harness.made_run import edit_table, make_run

VOID = {"meta", "link", "img", "br", "input", "path", "use", "rect", "line", "circle", "stop"}


class Page(html.parser.HTMLParser):
    """What a test asks of a page: its ids, what it loads, its text by tag, and whether tags close."""

    def __init__(self, text):
        super().__init__()
        self.ids, self.loads, self.open, self.found = [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        if "id" in given:
            self.ids.append(given["id"])
        self.loads += [given[key] for key in ("src", "data") if key in given]
        if tag == "link":
            self.loads.append(given.get("href"))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        given = dict(attrs)
        if "id" in given:
            self.ids.append(given["id"])

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data):
        self.found.append((self.open[-1] if self.open else "", data))

    def text(self, tag):
        return [data.strip() for name, data in self.found if name == tag and data.strip()]


def png(path):
    """One black pixel."""

    def chunk(kind, data):
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    head = chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 0, 0, 0, 0))
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zlib.compress(b"\0\0")) + chunk(b"IEND", b"")
    )


@pytest.fixture(scope="module")
def run_folder(tmp_path_factory):
    folder = make_run(tmp_path_factory.mktemp("run"))
    (folder / "images").mkdir()
    png(folder / "images/torus_level_3.png")
    return folder


@pytest.fixture(scope="module")
def text(run_folder):
    return write_report(run_folder).read_text()


def document(folder, name):
    return next(made for made in documents(folder) if made["id"] == name)


def test_report_is_one_well_formed_file_that_loads_nothing(text):
    page = Page(text)
    assert page.open == []
    assert page.loads
    assert all(address.startswith("data:image/png;base64,") for address in page.loads)
    assert "http" not in re.sub(r"xmlns(:xlink)?=\"[^\"]*\"", "", text)


def test_report_has_every_id_once(text):
    ids = Page(text).ids
    assert len(ids) == len(set(ids))
    targets = set(re.findall(r'href="#([^"]+)"', text)) | set(re.findall(r"url\(#([^)]+)\)", text))
    assert targets <= set(ids)


def test_report_escapes_what_it_is_given(text):
    assert "<script>alert" not in text
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in text
    assert "Test CPU &lt;x&gt;" in text


def test_report_says_what_was_measured_and_where(text):
    page = Page(text)
    assert "Level of detail on Test CPU <x>" in page.text("h1")
    assert "emulated on CPU" in page.text("span")
    assert [words for words in page.text("h2")] == [
        "Clustering against edge collapse", "Refinement patterns", "Pictures", "How to read this",
        "Where it was measured", "How to do it again",
    ]  # fmt: skip
    for words in ("30 ok", "1 noisy", "4 skipped", "1 failed"):
        assert words in page.text("span")
    assert "git checkout 0a1b2c3" in text
    assert "lodbench reproduce clustering patterns --quick" in text
    assert "Portable Computing Language" in text
    assert "27 GB/s best" in text


def test_report_does_not_call_a_gpu_emulated(tmp_path, monkeypatch):
    monkeypatch.setattr(plots, "write_figures", lambda folder, run: [])
    folder = make_run(tmp_path)
    run = json.loads((folder / "run.json").read_text())
    run["device"]["kind"] = "gpu"
    (folder / "run.json").write_text(json.dumps(run))
    made = write_report(folder).read_text()
    assert "emulated on CPU" not in made
    assert "Level of detail on pthread-test" in made


def test_report_has_the_same_bytes_each_time(run_folder, text):
    assert write_report(run_folder).read_text() == text


def test_report_of_a_run_without_tables(tmp_path):
    folder = make_run(tmp_path)
    for path in (folder / "tables").iterdir():
        path.unlink()
    assert "How to do it again" in write_report(folder).read_text()


def test_report_refuses_a_folder_that_is_no_run(tmp_path):
    with pytest.raises(ValueError, match=r"run: expected a folder with run\.json"):
        write_report(tmp_path)


def test_columns_without_a_value_are_left_out_and_ends_join_their_value(run_folder):
    shown = columns(document(run_folder, "patterns"))
    keys = [column.key for column in shown]
    assert keys[0] == "status"
    assert "reason" not in keys  # stands under the system's name
    assert "wall_s_lower" not in keys
    wall = next(column for column in shown if column.key == "wall_s")
    assert (wall.low, wall.high) == ("wall_s_lower", "wall_s_upper")
    assert "rms_error" not in [c.key for c in columns({**document(run_folder, "clustering"),
                                                     "rows": []})]  # fmt: skip


def test_each_column_has_one_unit(run_folder):
    made = document(run_folder, "clustering")
    units = {column.key: column.unit for column in columns(made)}
    assert units["wall_s"] == "ms"
    assert units["stored_bytes"] == "kB"
    assert units["rms_error"] == "×10⁻³"
    assert units["triangles_in"] == ""


def test_cells_show_four_digits_and_keep_the_whole_number(run_folder):
    made = document(run_folder, "clustering")
    made["rows"] = made["rows"][:1]
    row = made["rows"][0]
    row |= {
        "wall_s": 0.0123456,
        "wall_s_lower": 0.0121,
        "wall_s_upper": 0.013,
        "reason": "as it is",
    }
    shown = columns(made)
    cells = dict(zip([c.key for c in shown], lines(made, ["dataset"], shown)[0].cells, strict=True))
    wall = cells["wall_s"]
    assert (wall.text, wall.range) == ("12.35", "[12.1, 13]")
    assert (wall.exact, wall.sort) == ("0.0123456", "0.0123456")
    assert cells["triangles_in"].text == "20,480"
    assert cells["status"].status
    assert cells["system"].why == "as it is"


def test_published_columns_are_set_apart(run_folder, text):
    shown = columns(document(run_folder, "patterns"))
    assert [c.key for c in shown if "claim" in c.css] == ["published_frame_fps"]
    assert "published on a GeForce 1" in text


def test_wide_tables_leave_out_the_emptiest_columns_on_paper(run_folder, text):
    narrow = columns(document(run_folder, "patterns"))
    assert not any("extra" in column.css for column in narrow)
    made = document(run_folder, "clustering")
    for i in range(4):
        made["columns"].append({"key": f"rare_{i}", "label": "rare", "unit": ""})
        for number, row in enumerate(made["rows"]):
            row[f"rare_{i}"] = 1 if number <= i else None
    shown = columns(made)
    extra = {column.key for column in shown if "extra" in column.css}
    assert len(shown) - len(extra) == 14
    assert extra >= {f"rare_{i}" for i in range(4)} | {"wall_s_min"}
    assert not extra & {"status", "system", "wall_s", "rms_error"}
    assert "On paper some columns are left out: tables/clustering.csv has all of them." in text


def test_headlines_give_the_median_ratio_of_the_tables_subject(run_folder, tmp_path):
    made = document(run_folder, "clustering")
    ratios = [r["ratio_to_fast_simplification"] for r in made["rows"]
              if r["system"] == "quadric_clustering"]  # fmt: skip
    line = headlines(made)[0]
    assert line.before == "quadric_clustering is"
    assert line.after.startswith("as fast as fast_simplification (median of 4 cases")
    assert min(ratios) < float(line.value.removesuffix(" times")) < max(ratios)
    edit_table(run_folder, "clustering", lambda made: None)
    for row in made["rows"]:
        row["ratio_to_fast_simplification"] = None
    assert headlines(made) == []


def test_cases_are_separated(run_folder):
    made = document(run_folder, "clustering")
    opened = [line.first for line in lines(made, ["dataset"], columns(made))]
    assert opened == [i % 6 == 0 and i > 0 for i in range(24)]


def test_inline_drawings_follow_the_page(run_folder, text):
    svg = (
        '<?xml version="1.0"?><!DOCTYPE svg><svg width="3"><metadata>x</metadata>'
        '<defs><path id="m1" d="M 1.23456 0.98765"/></defs><use xlink:href="#m1"/>'
        '<g clip-path="url(#m1)"><text style="fill: #1f2328">1.23456 ms</text></g></svg>'
    )
    made = inline(svg, "a-b", 'Say "hello"')
    assert made.startswith('<svg width="3" role="img" aria-label="Say &#34;hello&#34;">')
    assert 'id="a-b-m1" d="M 1.23 0.98"' in made
    assert 'href="#a-b-m1"' in made
    assert "url(#a-b-m1)" in made
    assert "fill: var(--ink)" in made
    assert "1.23456 ms" in made  # text is not a coordinate
    assert "metadata" not in made
    assert "#1f2328" not in re.sub(r"<style>.*?</style>", "", text, flags=re.S)
