"""The report as Chromium shows it, where that is installed (Debian: `apt-get install chromium`)."""

import json

import numpy as np
import pytest
from PIL import Image

from lodbench.harness.report import claims
from lodbench.harness.report.page import write_report
from lodbench.harness.report.table_view import MOST
from tests.harness.made_run import make_run
from tests.harness.report.chromium import Chromium, browser

PROGRAM = browser()
pytestmark = pytest.mark.skipif(PROGRAM is None, reason="no Chromium: apt-get install chromium")
SIZES = ((1280, 800), (400, 800))
SCREEN = (1280, 800)


def judged(run):
    """Twenty claims as long as those of the papers."""
    text = "a geometry shader that evaluates a surface once and reuses it for samples is faster than without"
    verdicts = [claims.CONFIRMED, claims.REFUTED, claims.PARTLY, claims.UNDECIDED]
    return [
        {"name": f"c{i}", "claim": text, "source": "Someone 1999, section 5", "published": "3.8 against 4 fps",
         "measured": "1.45 to 1.69 times faster (1.41 to 1.71)", "verdict": verdicts[i % 4],
         "reason": "in 3 of 4 cases", "cases": []}
        for i in range(20)
    ]  # fmt: skip


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = make_run(tmp_path_factory.mktemp("run"))
    (folder / "images").mkdir()
    listed = []
    for series, count in (("methods", 10), ("levels", 4)):
        for k in range(count):
            colour = np.full((430, 512, 3), 20 * k, np.uint8)
            Image.fromarray(colour).save(folder / f"images/{series}_{k}.png")
            listed.append({"file": f"{series}_{k}.png", "caption": f"ball by {series} {k}", "series": series,
                           **({"level": k} if series == "levels" else {"table": "clustering"})})  # fmt: skip
    (folder / "images/pictures.json").write_text(json.dumps(listed))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(claims, "verdicts", judged)
        return write_report(folder)


@pytest.fixture(scope="module")
def chromium():
    with Chromium(PROGRAM) as found:
        yield found


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", SIZES)
def test_page_fits_its_width_without_a_complaint(chromium, page, size, scheme):
    chromium.open(page, *size, scheme)
    assert chromium.run("document.documentElement.scrollWidth") <= size[0]
    chromium.run(
        "document.querySelectorAll('details').forEach(d => { d.open = true }),"
        "document.querySelectorAll('button.columns').forEach(b => b.click())"
    )
    assert chromium.run("document.documentElement.scrollWidth") <= size[0]
    assert chromium.complaints == []


def test_twenty_claims_the_pareto_picture_and_the_rivals_are_on_the_first_screen(chromium, page):
    chromium.open(page, *SCREEN)
    bottom = "document.querySelector('{}').getBoundingClientRect().bottom"
    assert chromium.run(bottom.format(".glance")) <= SCREEN[1]
    assert chromium.run("document.querySelectorAll('.claims .verdict').length") == 20
    assert chromium.run("document.querySelector('.glance svg').getBoundingClientRect().width") > 300
    assert chromium.run("document.querySelector('.rivals img').getBoundingClientRect().width") > 100


def test_page_is_dark_where_the_reader_likes_it_and_the_button_turns_it(chromium, page):
    colour = "getComputedStyle(document.body).backgroundColor"
    ink = "getComputedStyle(document.querySelector('.glance svg text')).fill"
    chromium.open(page, *SCREEN, "light")
    light = chromium.run(colour), chromium.run(ink)
    assert light[0] == "rgb(255, 255, 255)"
    chromium.open(page, *SCREEN, "dark")
    dark = chromium.run(colour), chromium.run(ink)
    assert dark[0] != light[0] and dark[1] != light[1]
    chromium.run("document.getElementById('theme').click()")
    assert (chromium.run(colour), chromium.run(ink)) == light


def test_a_click_sorts_a_second_turns_round_a_third_restores(chromium, page):
    chromium.open(page, *SCREEN)
    column = "[...document.querySelectorAll('#rows-1 th')].findIndex(h => h.textContent.includes('median wall'))"
    values = (
        f"(i => [...document.querySelectorAll('#rows-1 tbody tr')].map(r => r.cells[i].dataset.v ?? "
        f"r.cells[i].firstChild.data))({column})"
    )
    click = f"document.querySelectorAll('#rows-1 th button')[{column}].click()"
    before = chromium.run(values)
    chromium.run(click)
    rising = chromium.run(values)
    chromium.run(click)
    falling = chromium.run(values)
    chromium.run(click)
    assert chromium.run(values) == before
    known = [float(text) for text in rising if text != "–"]
    assert known == sorted(known) and len(known) < len(rising)
    assert [float(text) for text in falling if text != "–"] == known[::-1]
    assert rising[-1] == falling[-1] == "–"  # what is unknown stays last


def test_eight_columns_until_all_are_asked_for_and_the_first_stays(chromium, page):
    chromium.open(page, 400, 800)
    seen = "[...document.querySelectorAll('#rows-1 thead th')].filter(h => h.offsetParent !== null).length"
    assert chromium.run(seen) == MOST
    chromium.run("document.querySelector('[aria-controls=rows-1]').click()")
    assert chromium.run(seen) > MOST
    left = "document.querySelector('#rows-1 tbody td').getBoundingClientRect().left"
    before = chromium.run(left)
    chromium.run("document.querySelector('#rows-1').parentElement.scrollLeft = 300")
    assert chromium.run("document.querySelector('#rows-1').parentElement.scrollLeft") > 0
    assert chromium.run(left) == pytest.approx(before, abs=1)


def test_slider_shows_one_level_at_a_time(chromium, page):
    chromium.open(page, *SCREEN)
    shown = "[...document.querySelectorAll('#levels figure')].map(f => f.offsetParent !== null)"
    assert chromium.run(shown) == [True, False, False, False]
    chromium.run(
        "(i => { i.value = 2; i.dispatchEvent(new Event('input')); })(document.querySelector('#levels input'))"
    )
    assert chromium.run(shown) == [False, False, True, False]
    text = chromium.run("document.querySelector('#levels input').getAttribute('aria-valuetext')")
    assert text == "ball by levels 2"


def test_page_prints(chromium, page, tmp_path):
    chromium.open(page, *SCREEN, "dark")
    chromium.paper(tmp_path / "a.pdf")
    assert (tmp_path / "a.pdf").read_bytes().startswith(b"%PDF")
    chromium.ask("Emulation.setEmulatedMedia", media="print")
    assert chromium.run("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    shown = "[...document.querySelectorAll('#levels figure')].every(f => f.offsetParent !== null)"
    assert chromium.run(shown)
    chromium.ask("Emulation.setEmulatedMedia", media="")
