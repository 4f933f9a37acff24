from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
import pytest

from lodbench.kernels.parameters import Parameters, Range, check, closest


@dataclass(frozen=True)
class Params(Parameters):
    count: Annotated[int, Range(1, 4)] = 2
    share: Annotated[float, Range(0, 1, open="high")] = 0.5
    far: Annotated[float, Range(0, open="low")] | None = None
    way: Literal["fused", "separate"] = "fused"
    weld: bool = True
    cells: int | float | tuple[int, int, int] = 64


@pytest.mark.parametrize(
    ("values", "error", "text"),
    [
        ({"count": 2.5}, TypeError, "count: expected a whole number, got 2.5"),
        ({"count": 2.0}, TypeError, "count: expected a whole number, got 2.0"),
        ({"count": "2"}, TypeError, "count: expected a whole number, got '2'"),
        ({"count": True}, TypeError, "count: expected a whole number, got True"),
        ({"count": 5}, ValueError, "count: expected 1 to 4, got 5"),
        ({"share": 1}, ValueError, "share: expected 0 to below 1, got 1"),
        ({"share": float("nan")}, ValueError, "share: expected a finite number, got nan"),
        ({"share": "x"}, TypeError, "share: expected a number, got 'x'"),
        ({"far": 0.0}, ValueError, "far: expected more than 0, got 0.0"),
        ({"far": "x"}, TypeError, "far: expected a number, more than 0 or None, got 'x'"),
        ({"way": "fuse"}, ValueError, "way: expected one of fused, separate, got 'fuse'"),
        ({"way": 3}, TypeError, "way: expected one of fused, separate, got 3"),
        ({"weld": "yes"}, TypeError, "weld: expected True or False, got 'yes'"),
        ({"weld": 1}, TypeError, "weld: expected True or False, got 1"),
        ({"cells": (1, 2)}, TypeError, "cells: expected a whole number or a number or"),
        ({"cells": (1, 2, 2.5)}, TypeError, "cells: expected a whole number or a number or"),
    ],
)
def test_value_of_another_kind_is_refused_by_name(values, error, text):
    with pytest.raises(error) as raised:
        Params(**values)
    assert str(raised.value).startswith(text)


def test_values_become_pythons_own():
    made = Params(
        np.int64(3), np.float32(0.25), np.float64(2), "separate", np.bool_(False), [1, 2, 3]
    )
    assert made == Params(3, 0.25, 2.0, "separate", False, (1, 2, 3))
    kinds = [type(getattr(made, name)) for name in ("count", "share", "weld", "cells")]
    assert kinds == [int, float, bool, tuple]
    assert Params(cells=np.int32(9)).cells == 9
    assert Params(far=None).far is None


def test_unknown_name_is_refused_with_the_closest():
    with pytest.raises(TypeError, match=r"option: expected one like weld, got 'weldd'"):
        Params.named(weldd=True)
    assert Params.named(weld=False) == Params(weld=False)
    assert closest("x", "zzz", ["b", "a"]) == "x: expected one of a, b, got 'zzz'"


def test_range_ends():
    assert [v in Range(0, 1) for v in (0, 0.5, 1, -1)] == [True, True, True, False]
    assert [v in Range(0, 1, open="high") for v in (0, 1)] == [True, False]
    assert [v in Range(0, 1, open="low") for v in (0, 1)] == [False, True]
    assert str(Range(0, 1, open="low")) == "above 0 to 1"
    assert str(Range(0)) == "at least 0"


def test_check_takes_a_pair_of_numbers():
    assert check("size", [640, np.int16(480)], tuple[int, int]) == (640, 480)
    for wrong in ((2.5, 3), (3,), "ab", 7, None):
        with pytest.raises(TypeError, match="size: expected"):
            check("size", wrong, tuple[int, int])


@pytest.mark.parametrize(
    ("value", "kind", "error"),
    [
        (np.zeros((9, 9)), int, TypeError),
        (np.array(["a", "b"]), Literal["a", "b"], TypeError),
        (["a"], Literal["a", "b"], TypeError),
        (True, Literal[1, 2], TypeError),
        (10**400, float, ValueError),
        (10**9999, Annotated[int, Range(1, 4)], ValueError),
        ("word " * 99, int, TypeError),
    ],
    ids=range(7),
)
def test_error_is_one_short_line_whatever_came(value, kind, error):
    with pytest.raises(error, match=r"^x: expected .*, got .+") as raised:
        check("x", value, kind)
    assert "\n" not in str(raised.value)
    assert len(str(raised.value)) < 150


def test_arrays_of_numpy_are_scalars_and_tuples():
    assert check("x", np.array(3), int) == 3
    assert type(check("x", np.array(0.5), float)) is float
    assert Params(cells=np.array([3, 2, 1])).cells == (3, 2, 1)


def test_named_params_that_came_before_are_told_from_those_that_are_equal():
    assert Params.named(count=1) is Params.named(count=1)
    for wrong in (True, 1.0):
        with pytest.raises(TypeError, match="count: expected a whole number"):
            Params.named(count=wrong)
    assert type(Params.named(share=0).share) is int and type(Params.named(share=0.0).share) is float
