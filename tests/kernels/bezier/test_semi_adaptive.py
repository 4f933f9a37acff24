import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lodbench.datasets_gen import patches
from lodbench.kernels import tessellate
from lodbench.kernels.bezier.candidates import NODES, nodes_of, triangle_counts
from lodbench.kernels.bezier.semi_adaptive import Params, SemiAdaptive
from lodbench.kernels.bezier.semi_adaptive.reference import inserted, pattern_count
from lodbench.kernels.bezier.strips import strips
from lodbench.kernels.system import run

NONE = np.zeros(7, bool)
NOTHING = np.zeros(NODES, bool)


def edge(number):
    """The edge of a number, places 1 to 7."""
    found = NONE.copy()
    if number:
        found[3] = True
        for middle, own in ((1, (number - 1) // 5), (5, (number - 1) % 5)):
            if own:
                found[[middle, middle - 1, middle + 1]] = 1, (own - 1) // 2, (own - 1) % 2
    return found


@pytest.fixture(scope="module")
def semi_patterns(device):
    prepared = SemiAdaptive(device, patches.cup(), Params(3))
    return device.read(prepared.shapes), device.read(prepared.lists)


def test_semi_adaptive_rows_are_whole_or_empty():
    on = np.stack([edge(1), edge(0), edge(1)])  # the middle of the left, and of the base
    flags = inserted(on, NOTHING, 3)
    assert flags.sum() == 3 + 2  # row 4 has no column of the base inside
    on = np.stack([edge(25), edge(0), edge(25)])
    assert inserted(on, NOTHING, 3).sum() == 3 + 7 + 7 + 21  # missing on the right alone
    on = np.stack([edge(0), edge(0), edge(25)])
    assert inserted(on, NOTHING, 3).sum() == 3 + 7  # empty rows


@given(st.integers(0, pattern_count(3) - 1))
def test_semi_adaptive_patterns_are_those_of_the_reference(semi_patterns, number):
    shapes, lists = semi_patterns
    edges = np.stack([edge(number // 676), edge(number // 26 % 26), edge(number % 26)])
    flags = inserted(edges, NOTHING, 3)
    assert np.array_equal(nodes_of(shapes[number]), flags)
    count = int(triangle_counts(flags))
    corners = lists[number].view(np.uint8)[: 3 * count].reshape(-1, 3)
    assert corners.tolist() == [list(t) for t in strips(int(shapes[number]))]


def test_semi_adaptive_work_is_more_even_than_that_of_dabt(device):
    from lodbench.kernels.bezier.dabt import Dabt
    from lodbench.kernels.bezier.dabt import Params as DabtParams

    surface = patches.cup()
    found = []
    for kind, params in ((SemiAdaptive, Params), (Dabt, DabtParams)):
        prepared = kind(device, surface, params(5))
        run(device, prepared)
        found.append(prepared.counters())
    assert found[0]["lanes_used"] > found[1]["lanes_used"]


def test_semi_adaptive_from_python():
    points, faces = tessellate(patches.cup(), method="semi_adaptive", level=4, quality="low")
    assert points.dtype == np.float32 and len(faces) < 26 * 2 * 4**4
