import re

import pytest

from lodbench.harness.report.charts.chart_data import ON_COLOUR, PALETTE, STAGES
from lodbench.harness.report.drawings import DARK_PAGE, Drawings, contrast, dark

HEAD = (
    '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
    'width="30pt" viewBox="0 0 30 20">'
)


def svg(inside):
    return f"{HEAD}<metadata>x</metadata>{inside}</svg>"


def test_drawings_follow_the_page_and_share_styles_and_no_ids():
    text = svg(
        '<defs><path id="m1" d="M 1.23456 0.98765"/></defs><g id="unused"><use xlink:href="#m1" x="12.3456" y="3"/></g>'
        '<g><text style="font-size: 8px; fill: #1f2328">1.23456 ms &lt;</text></g>'
    )
    drawings = Drawings()
    one, other = drawings.inline(text, 'Say "hello"'), drawings.inline(text, "b")
    assert one.startswith('<svg viewBox="0 0 30 20" style="--w:30pt" role="img" ')
    assert 'aria-label="Say &#34;hello&#34;"' in one
    assert '<path id="d1" d="M1.23 .99"/>' in one and '<use href="#d1" x="12.3" y="3"/>' in one
    assert '<path id="d2"' in other and '<use href="#d2"' in other
    assert '<text class="s0">1.23456 ms &lt;</text>' in one  # text is no coordinate
    assert 'class="s0"' in other
    assert "unused" not in one and "metadata" not in one and "xmlns" not in one
    assert ".s0{font-size:8px;fill:var(--ink)}" in drawings.css()


def test_a_path_keeps_its_way_in_fewer_letters():
    drawn = Drawings().inline(
        svg('<path d="M 1.0 2.0 \nL 11.04 2.0 \nL 11.04 15.26 \nL 1.0 15.26 \nz\n"/>'), "a"
    )
    assert 'd="M1 2h10v13.3h-10z"' in drawn
    dots = '<path d="M 1.0 2.0 \nL 1.5 2.0 \nM 4.04 1.46 \nL 4.5 1.5 \nz\nM 3.0 3.0 \nL 4.0 4.0"/>'
    assert 'd="M1 2h.5m2.54-.54l.46 .04zm-1.04 1.54l1 1"' in Drawings().inline(svg(dots), "a")
    curved = Drawings().inline(svg('<path d="M 0 1 C 1 2 3 4 5 6"/>'), "a")
    assert 'd="M0 1C1 2 3 4 5 6"' in curved


def test_paths_of_one_style_are_one_and_others_are_not():
    text = svg(
        '<g><path d="M 0 0 L 1 1" style="fill: none"/></g><g><path d="M 2 2 L 3 3" style="fill: none"/></g>'
        '<path d="M 4 4 L 5 5" style="fill: red"/>'
    )
    assert Drawings().inline(text, "a").count("<path") == 2


def test_a_clip_that_cuts_something_off_stays():
    clip = '<defs><clipPath id="c"><rect x="5" y="5" width="10" height="10"/></clipPath></defs>'
    inside = '<path d="M 6 6 L 9 9" clip-path="url(#c)"/>'
    outside = '<path d="M 6 6 L 90 9" clip-path="url(#c)"/>'
    assert "url(#" not in Drawings().inline(svg(clip + inside), "a")
    assert "url(#d1)" in Drawings().inline(svg(clip + outside), "a")


def test_scripts_do_not_come_along_and_broken_files_are_refused():
    assert "alert" not in Drawings().inline(svg("<script>alert(1)</script>"), "a")
    with pytest.raises(ValueError, match="svg: expected a drawing, got"):
        Drawings().inline("<svg><g></svg>", "a")


def test_colours_stand_out_on_a_dark_page():
    for colour in (*PALETTE, *STAGES):
        assert contrast(dark(colour), DARK_PAGE) >= 4
    assert dark("#0072b2") != "#0072b2" and dark("#e69f00") == "#e69f00"
    assert dark(ON_COLOUR) == ON_COLOUR
    assert contrast("#000000", "#ffffff") == pytest.approx(21)
    drawings = Drawings()
    drawings.inline(svg('<path d="M 0 0" style="fill: #0072b2"/>'), "a")
    assert "fill:var(--0072b2,#0072b2)" in drawings.css()
    assert re.search(r"--0072b2:light-dark\(#0072b2,#[0-9a-f]{6}\)", drawings.css())
