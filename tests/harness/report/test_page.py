import html.parser
import json
import re
import struct
import zlib

import pytest

from lodbench.harness.report import plots
from lodbench.harness.report.page import write_report
from lodbench.harness.report.plots import documents
from lodbench.harness.report.table_view import MOST, columns, headlines, lines
from tests.harness.made_run import edit_table, make_run

VOID = {"meta", "link", "img", "br", "input", "path", "use", "rect", "line", "circle", "stop"}
OPTIONAL = {"td", "tr"}  # HTML closes them by itself


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
        if tag not in VOID | OPTIONAL:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        given = dict(attrs)
        if "id" in given:
            self.ids.append(given["id"])

    def handle_endtag(self, tag):
        if tag not in VOID | OPTIONAL:
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
def figures(run_folder):
    return plots.write_figures(run_folder)


@pytest.fixture(scope="module")
def text(run_folder, figures):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plots, "write_figures", lambda folder, run: figures)
        return write_report(run_folder).read_text()


def document(folder, name):
    return next(made for made in documents(folder) if made["id"] == name)


def test_report_is_one_well_formed_file_that_loads_nothing(text):
    page = Page(text)
    assert page.open == []
    assert page.loads
    assert all(address.startswith("data:image/webp;base64,") for address in page.loads)
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
    heads = page.text("h2")
    for words in (
        "Tables", "Clustering against edge collapse", "Refinement patterns", "Every claim", "Pictures",
        "How to read this", "Where it was measured", "How to do it again",
    ):  # fmt: skip
        assert words in heads
    assert heads[0].startswith("What the papers claim")
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
    assert keys[0] == "system"
    assert "reason" not in keys  # stands under the system's name
    assert "wall_s_lower" not in keys
    wall = next(column for column in shown if column.key == "wall_s")
    assert (wall.low, wall.high) == ("wall_s_lower", "wall_s_upper")
    assert "rms_error" not in [c.key for c in columns({**document(run_folder, "clustering"),
                                                     "rows": []})]  # fmt: skip


def test_first_columns_say_the_case_the_time_and_an_error_beside_a_speed_up(run_folder):
    made = document(run_folder, "clustering")
    keys = [column.key for column in columns(made, facts=["dataset", "triangles_in"])]
    assert len(keys) > MOST
    assert {"system", "dataset", "triangles_in", "wall_s", "rms_error"} < set(keys[:MOST])
    assert "ratio_to_fast_simplification" in keys[:MOST]
    assert "status" in keys[MOST:]
    asked = ["system", "dataset", "open_edges"]
    keys = [column.key for column in columns(made, asked, ["dataset"])]
    assert set(asked) < set(keys[:MOST])


def test_page_hides_the_other_columns_until_they_are_asked_for(text):
    assert f":nth-child(n+{MOST + 1}) {{ display: none; }}" in text
    assert re.search(r"<button[^>]*aria-pressed=.false.[^>]*>all \d+ columns</button>", text)
    assert "all of it in tables/clustering.csv" in text


def test_each_column_has_one_unit(run_folder):
    made = document(run_folder, "clustering")
    units = {column.key: column.unit for column in columns(made)}
    assert units["wall_s"] == "ms"
    assert units["stored_bytes"] == "kB"
    assert units["rms_error"] == "×10⁻³"
    assert units["triangles_in"] == ""


def test_cells_show_four_digits_and_keep_more_of_the_number(run_folder):
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
    assert (wall.text, wall.range, wall.exact) == ("12.35", "[12.1, 13]", "0.0123456")
    triangles = cells["triangles_in"]
    assert (triangles.text, triangles.exact) == ("20,480", "")  # nothing to add
    assert cells["system"].why == "as it is"


def test_published_columns_are_set_apart(run_folder, text):
    shown = columns(document(run_folder, "patterns"))
    assert [c.key for c in shown if "c" in c.css.split()] == ["published_frame_fps"]
    assert "published on a GeForce 1" in text


def test_headlines_give_the_median_ratio_of_the_tables_subject(run_folder, tmp_path):
    made = document(run_folder, "clustering")
    ratios = [r["ratio_to_fast_simplification"] for r in made["rows"]
              if r["system"] == "quadric_clustering"]  # fmt: skip
    line = headlines(made)[0]
    assert line.before == "quadric_clustering is"
    assert line.after.startswith("as fast as fast_simplification (median of 4 cases")
    assert min(ratios) < float(line.value.removesuffix(" times")) < max(ratios)
    with_errors = headlines(made, ["dataset"])[0]
    assert (
        re.search(r"with 1\.25? times its RMS error", with_errors.after)
        or "1.2" in with_errors.after
    )
    edit_table(run_folder, "clustering", lambda made: None)
    for row in made["rows"]:
        row["ratio_to_fast_simplification"] = None
    assert headlines(made) == []


def test_cases_are_separated(run_folder):
    made = document(run_folder, "clustering")
    opened = [line.first for line in lines(made, ["dataset"], columns(made))]
    assert opened == [i % 6 == 0 and i > 0 for i in range(24)]


def test_first_screen_has_claims_the_pareto_picture_and_the_rivals(tmp_path, figures, monkeypatch):
    monkeypatch.setattr(plots, "write_figures", lambda folder, run: figures)
    folder = make_run(tmp_path)
    (folder / "images").mkdir()
    listed = []
    for number in range(12):
        png(folder / f"images/m{number}.png")
        listed.append({"file": f"m{number}.png", "caption": f"ball by m{number}: 9 triangles",
                       "series": "methods", "table": "clustering", "name": f"m{number}"})  # fmt: skip
    (folder / "images/pictures.json").write_text(json.dumps(listed))
    made = write_report(folder).read_text()
    first = made[made.index('id="first"') : made.index("</section>")]
    assert first.count("<img") == 10  # the others open their table
    assert made.count("<img") == 12
    assert "Who is faster, who is nearer" in first and "<svg" in first
    assert "not measured here" in first


def test_levels_are_a_slider_and_other_pictures_of_a_table_open_it(tmp_path, figures, monkeypatch):
    monkeypatch.setattr(plots, "write_figures", lambda folder, run: figures)
    folder = make_run(tmp_path)
    (folder / "images").mkdir()
    listed = []
    for number in range(3):
        png(folder / f"images/l{number}.png")
        png(folder / f"images/p{number}.png")
        listed.append({"file": f"l{number}.png", "caption": f"level {number}", "series": "levels",
                       "level": number})  # fmt: skip
    listed += [{"file": f"p{number}.png", "caption": f"part {number}", "series": "parts",
                "table": "patterns"} for number in range(3)]  # fmt: skip
    (folder / "images/pictures.json").write_text(json.dumps(listed))
    made = write_report(folder).read_text()
    levels = made[made.index('id="levels"') : made.index("Frames per second are")]
    assert levels.count("<img") == 3 and 'max="2"' in levels
    section = made[made.index('id="table-patterns"') :]
    opening = section[: section.index("<table")]
    assert opening.count("<img") == 3 and "<svg" in opening
    assert 'type="range"' not in opening
