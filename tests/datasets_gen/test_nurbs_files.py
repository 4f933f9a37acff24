import json

import numpy as np
import pytest

from lodbench.datasets_gen import nurbs
from lodbench.datasets_gen.nurbs_files import read_nurbs
from lodbench.datasets_gen.read import FileError


def entry(surface):
    return {
        "degree_u": surface.degree_u,
        "degree_v": surface.degree_v,
        "knots_u": surface.knots_u.tolist(),
        "knots_v": surface.knots_v.tolist(),
        "control_points": surface.points.tolist(),
        "weights": surface.weights.tolist(),
    }


def section(letter, lines):
    return [f"{line:<72}{letter}{k:7d}" for k, line in enumerate(lines, 1)]


def iges(model, matrix=None, double="E"):
    """A file of the model's surfaces in fixed form, each moved by `matrix` if there is one."""
    bodies = []
    for s in model.surfaces:
        (n_u, n_v), numbers = s.points.shape[:2], []
        numbers += [128, n_u - 1, n_v - 1, s.degree_u, s.degree_v, 0, 0, int(not s.rational), 0, 0]
        numbers += [*s.knots_u, *s.knots_v, *s.weights.T.ravel()]
        numbers += [*s.points.transpose(1, 0, 2).ravel()]
        numbers += [s.knots_u[0], s.knots_u[-1], s.knots_v[0], s.knots_v[-1]]
        bodies.append(numbers)
    if matrix is not None:
        bodies.append([124, *np.ravel(matrix)])
    directory, parameters = [], []
    for k, numbers in enumerate(bodies):
        words = [repr(int(n)) if float(n).is_integer() else f"{float(n)!r}" for n in numbers]
        text = ",".join(words).replace("e", double) + ";"
        rows = [text[i : i + 64] for i in range(0, len(text), 64)]
        moved = 2 * len(bodies) - 1 if matrix is not None and numbers[0] == 128 else 0
        first = "".join(
            f"{n:8d}" for n in (numbers[0], len(parameters) + 1, 0, 0, 0, 0, moved, 0, 0)
        )
        second = "".join(f"{n:8d}" for n in (numbers[0], 0, 0, len(rows), 0))
        directory += [first, second]
        parameters += [f"{row:<64}{2 * k + 1:8d}" for row in rows]
    head = section("S", ["test"]), section("G", ["1H,,1H;,4Htest;"])
    parts = [*head, section("D", directory), section("P", parameters)]
    counts = "".join(f"{letter}{len(part):7d}" for letter, part in zip("SGDP", parts, strict=True))
    return "\n".join(line for part in [*parts, section("T", [counts])] for line in part) + "\n"


def step(model):
    lines, number = [], 0

    def add(text):
        nonlocal number
        number += 1
        lines.append(f"#{number} = {text};")
        return f"#{number}"

    def listed(values):
        return "(" + ",".join(values) + ")"

    def knots(values):
        found, counts = np.unique(values, return_counts=True)
        return listed(map(str, counts)), listed(repr(float(k)) for k in found)

    for s in model.surfaces:
        rows = [
            [
                add(f"CARTESIAN_POINT('it''s; #{number}',{listed(repr(float(x)) for x in p)})")
                for p in row
            ]
            for row in s.points
        ]
        base = f"{s.degree_u},{s.degree_v},{listed(map(listed, rows))},.UNSPECIFIED.,.F.,.F.,.U."
        (mu, ku), (mv, kv) = knots(s.knots_u), knots(s.knots_v)
        own = f"{mu},{mv},{ku},\n {kv},.UNSPECIFIED."
        if s.rational:
            weights = listed(listed(repr(float(w)) for w in row) for row in s.weights)
            add(
                f"( BOUNDED_SURFACE() B_SPLINE_SURFACE({base}) B_SPLINE_SURFACE_WITH_KNOTS({own}) "
                f"GEOMETRIC_REPRESENTATION_ITEM() RATIONAL_B_SPLINE_SURFACE({weights}) "
                "REPRESENTATION_ITEM('') SURFACE() )"
            )
        else:
            add(f"B_SPLINE_SURFACE_WITH_KNOTS ('a name', {base}, {own} )")
    add("ADVANCED_FACE('',(#1),#2,.T.)")
    add("PLANE('',#1)")
    body = "\n".join(lines)
    head = "ISO-10303-21;\nHEADER;\nFILE_NAME('a');\nENDSEC;\nDATA;\n/* a; comment */\n"
    return f"{head}{body}\nENDSEC;\nEND-ISO-10303-21;\n"


def assert_same(got, expected, tolerance=0.0):
    assert len(got.surfaces) == len(expected.surfaces)
    for one, other in zip(got.surfaces, expected.surfaces, strict=True):
        assert (one.degree_u, one.degree_v) == (other.degree_u, other.degree_v)
        for name in ("knots_u", "knots_v", "points", "weights"):
            assert np.abs(getattr(one, name) - getattr(other, name)).max() <= tolerance


MODELS = {"ball": nurbs.ball(), "quilt": nurbs.quilt(1, 2, 2), "mixed": nurbs.mixed_degrees()}


@pytest.mark.parametrize("name", MODELS)
def test_surfaces_come_back_from_each_format(tmp_path, name):
    model = MODELS[name]
    texts = {
        "a.json": json.dumps({"surfaces": [entry(s) for s in model.surfaces]}),
        "a.igs": iges(model),
        "b.IGES": iges(model, double="D"),
        "a.stp": step(model),
    }
    for file, text in texts.items():
        path = tmp_path / file
        path.write_text(text)
        assert_same(read_nurbs(path), model)
    assert read_nurbs(tmp_path / "a.stp").notes == (
        "trims of 1 faces are left out",
        "1 surfaces of other kinds are left out",
    )


def test_iges_surfaces_are_moved_by_their_transformation(tmp_path):
    path, (ball,) = tmp_path / "a.igs", nurbs.ball().surfaces
    path.write_text(iges(nurbs.ball(), matrix=[0, -1, 0, 5, 1, 0, 0, 6, 0, 0, 1, 7]))
    (moved,) = read_nurbs(path).surfaces
    turned = ball.points[..., [1, 0, 2]] * (-1, 1, 1) + (5, 6, 7)
    assert moved.points == pytest.approx(turned)


def test_real_models_are_read(data_folder):
    counts = {"killeroo": 89, "ducky": 3, "hammer_nd": 34, "cylinder_rational": 1}
    for name, count in counts.items():
        assert len(read_nurbs(data_folder / f"nurbs/{name}.json").surfaces) == count
    assert read_nurbs(data_folder / "nurbs/killeroo.json").span_count == 11_532


def faults():
    good = entry(nurbs.ball().surfaces[0])
    for text in (
        "", "{", "[]", '{"surfaces": 3}', '{"surfaces": [{}]}', '{"surfaces": [null]}', "[" * 100_000,
        json.dumps({"surfaces": [good | {"weights": [[1.0]]}]}),
        json.dumps({"surfaces": [good | {"knots_u": [0, 1]}]}),
        json.dumps({"surfaces": [good | {"control_points": [[["x"]]]}]}),
    ):  # fmt: skip
        yield ".json", text
    whole = iges(nurbs.ball())
    lines = whole.splitlines(keepends=True)
    yield from ((".igs", whole[: len(whole) * k // 7]) for k in range(7))
    yield from ((".igs", "".join(lines[:k] + lines[k + 1 :])) for k in range(0, len(lines), 5))
    yield ".igs", whole.replace("128,8,4", "128,9,4")
    yield ".igs", whole.replace("128,8,4", "128,x,4")
    yield ".igs", whole.replace(" 128 ", " 126 ")
    text = step(nurbs.ball())
    yield from ((".stp", text[: len(text) * k // 7]) for k in range(7))
    yield ".stp", text.replace("#3 =", "#9999 =")
    yield ".stp", text.replace("_WITH_KNOTS", "")
    yield ".stp", text.replace("B_SPLINE_SURFACE(2,", "B_SPLINE_SURFACE(9,")
    yield ".stp", text.replace("B_SPLINE_SURFACE(2,", "B_SPLINE_SURFACE(")
    yield ".stp", text.replace("SURFACE() )", "SURFACE()")


def test_broken_files_are_one_line(tmp_path):
    for suffix, text in faults():
        path = tmp_path / f"model{suffix}"
        path.write_text(text)
        with pytest.raises(FileError, match=r"model\.\w+: .+") as caught:
            read_nurbs(path)
        assert "\n" not in str(caught.value)
    with pytest.raises(FileError, match="no such file"):
        read_nurbs(tmp_path / "none.json")
    with pytest.raises(FileError, match="expected a suffix"):
        read_nurbs(tmp_path / "none.3dm")
