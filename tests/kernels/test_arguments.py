"""Arguments of the calls: wrong types and unknown names are refused by name, before any work."""

import numpy as np
import pytest

from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.plan.registry import systems
from lodbench.kernels import refine, simplify
from lodbench.kernels.parameters import Parameters

BALL = icosphere(1)


@pytest.mark.parametrize(
    ("call", "options", "error", "text"),
    [
        (refine, {"segments": 2.5}, TypeError, "segments: expected a whole number, got 2.5"),
        (refine, {"segments": "4"}, TypeError, "segments: expected a whole number, got '4'"),
        (refine, {"weld": "no"}, TypeError, "weld: expected True or False, got 'no'"),
        (refine, {"time": "now"}, TypeError, "time: expected a number, got 'now'"),
        (refine, {"segment": 4}, TypeError, "option: expected one like segments, "),
        (refine, {"amplitude": float("nan")}, ValueError, "amplitude: expected a finite number"),
        (simplify, {"target_count": "10"}, TypeError, "target_count: expected a whole number"),
        (simplify, {"target_count": 10.5}, TypeError, "target_count: expected a whole number"),
        (simplify, {"target_count": True}, TypeError, "target_count: expected a whole number"),
        (simplify, {"target_count": 0}, ValueError, "target_count: expected at least 1, got 0"),
        (simplify, {"target_reduction": "0.9"}, TypeError, "target_reduction: expected a number"),
        (simplify, {"target_reduction": 1}, ValueError, "target_reduction: expected 0 to below 1"),
        (simplify, {"cells": "9"}, TypeError, "cells: expected a number or (nx, ny, nz), got '9'"),
        (
            simplify, {"cells": 9, "remove_duplicates": "yes"}, TypeError,
            "remove_duplicates: expected True or False, got 'yes'",
        ),
        (
            simplify, {"cells": 9, "placment": "average"}, TypeError,
            "option: expected one like placement, got 'placment'",
        ),
        (simplify, {"cells": 10**400}, ValueError, "cells: expected at most 134,217,728 in all"),
        (simplify, {"cells": np.ones((3, 3))}, TypeError, "cells: expected a number or (nx, ny"),
        (simplify, {"cells": 9, "chunks": 1.0}, TypeError, "chunks: expected a whole number"),
        (simplify, {"cells": 9, "method": 3}, TypeError, "method: expected text or None, got 3"),
        (
            simplify, {"target_count": 9, "method": "quadtree_lod", "n": 4.0}, TypeError,
            "n: expected a whole number, got 4.0",
        ),
    ],
)  # fmt: skip
def test_wrong_argument_is_refused_by_name(device, call, options, error, text):
    with pytest.raises(error) as raised:
        call(BALL, device=device, **options)
    assert str(raised.value).startswith(text)


def test_cells_may_be_an_array(device):
    points, _ = simplify(BALL, cells=np.array([3, 4, 5]), device=device)
    expected, _ = simplify(BALL, cells=(3, 4, 5), device=device)
    np.testing.assert_array_equal(points, expected)


@pytest.mark.parametrize("name", systems())
def test_params_of_every_system_share_the_validation(name):
    for params in systems()[name].cases.values():
        assert isinstance(params, Parameters)
