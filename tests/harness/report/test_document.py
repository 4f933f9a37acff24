import csv
import io
import json

from lodbench.harness.plan.table import Column, Table
from lodbench.harness.report import document
from tests.harness.records import group, run


def test_written_table_is_the_same_in_json_csv_and_markdown(tmp_path):
    made = Table(
        "x", "A title", "A source", lambda quick: [],
        (Column("system", "system"), Column("wall_s", "median wall", "s"), Column("none", "empty")),
        also=lambda group: [{"system": "a|b", "wall_s": 0.00123456, "other": 3, "status": "ok"}],
        notes=("a note",),
    )  # fmt: skip
    record = run(group(table="x"))
    record.folder = tmp_path
    document.write(made, record)
    written = json.loads((tmp_path / "tables/x.json").read_text())
    assert {"id", "title", "source", "device", "columns", "rows"} <= set(written)
    assert written["columns"][1] == {"key": "wall_s", "label": "median wall", "unit": "s"}
    assert written["rows"] == [
        {"system": "a|b", "wall_s": 0.00123456, "none": None, "status": "ok", "reason": None}
    ]
    text = (tmp_path / "tables/x.md").read_text()
    assert r"| a\|b | 1.235 ms |" in text
    assert "empty" not in text
    assert "- a note" in text
    (row,) = csv.DictReader(io.StringIO((tmp_path / "tables/x.csv").read_text()))
    assert (row["wall_s"], row["none"]) == ("0.00123456", "")
