import re

import pytest

from lodbench.harness.report.latex import escaped, latex

MADE = {
    "id": "t", "title": "90 % of_it", "source": "A & B 1999", "device": "a #1 device",
    "columns": [
        {"key": "system", "label": "system", "unit": ""},
        {"key": "wall_s", "label": "median wall", "unit": "s"},
        {"key": "ratio", "label": "times faster", "unit": "1"},
        {"key": "ratio_low", "label": "low", "unit": "1"},
        {"key": "ratio_high", "label": "high", "unit": "1"},
        {"key": "status", "label": "status", "unit": ""},
        {"key": "reason", "label": "reason", "unit": ""},
        {"key": "empty", "label": "empty", "unit": ""},
    ],
    "rows": [
        {"system": "my_one", "wall_s": 0.0123456, "ratio": 3.0, "ratio_low": 2.5, "ratio_high": 3.5,
         "status": "ok", "reason": None, "empty": None},
        {"system": "other", "wall_s": 0.04, "ratio": None, "ratio_low": None, "ratio_high": None,
         "status": "noisy", "reason": "why", "empty": None},
    ],
}  # fmt: skip


def test_table_is_booktabs_with_a_unit_per_column_and_ranges_in_brackets():
    text = latex(MADE)
    assert r"system & median wall [ms] & times faster \\" in text
    assert r"my\_one & 12.35 & 3 {\footnotesize [2.5, 3.5]} \\" in text
    assert r"other$^{a}$ & 40 & -- \\" in text
    assert r"$^{a}$ noisy" in text
    assert r"\caption{90 \% of\_it. A \& B 1999. Device: a \#1 device.}" in text
    for rule in (r"\toprule", r"\midrule", r"\bottomrule", r"\begin{tabular}{lrr}"):
        assert rule in text
    rows = re.search(r"(?s)midrule\n(.*)\\bottomrule", text)[1].splitlines()
    assert {row.count(" & ") for row in rows} == {2}


def test_columns_are_those_of_a_terminal_where_a_table_names_some():
    assert r"times faster & system \\" in latex(MADE, ["ratio", "system"])


def test_table_without_rows_is_still_one():
    text = latex({**MADE, "rows": []})
    assert text.count("begin{") == text.count("end{") == 2


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a_b % & # $ {x}", r"a\_b \% \& \# \$ \{x\}"),
        ("~^\\", r"\textasciitilde{}\textasciicircum{}\textbackslash{}"),
        ("2 × 10⁻³ µs – <b>", r"2 $\times$ 10$^{-3}$ \textmu{}s -- \textless{}b\textgreater{}"),
    ],
)
def test_signs_with_a_meaning_are_made_plain(text, said):
    assert escaped(text) == said
