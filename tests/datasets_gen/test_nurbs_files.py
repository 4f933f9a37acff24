import json
import re

import numpy as np
import pytest

from lodbench.datasets_gen import nurbs
from lodbench.datasets_gen.nurbs_files import read_nurbs
from lodbench.datasets_gen.nurbs_surface import NurbsModel, NurbsSurface
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


def unclamped():
    """A bicubic sheet on uniform knots, closed along u: the last three rows are the first."""
    around = np.arange(11) % 8 * np.pi / 4
    x, y = np.cos(around)[:, None], np.sin(around)[:, None]
    net = np.stack(np.broadcast_arrays(x, y, np.arange(5.0)), axis=2)
    return 3, 3, np.arange(15.0), np.arange(9.0), net


class Raw:
    """A surface as a file has it, before it is clamped."""

    rational = False

    def __init__(self):
        self.degree_u, self.degree_v, self.knots_u, self.knots_v, self.points = unclamped()
        self.weights = np.ones(self.points.shape[:2])


def test_unclamped_periodic_surfaces_are_clamped_alike_by_each_format(tmp_path):
    raw = NurbsModel.__new__(NurbsModel)
    object.__setattr__(raw, "surfaces", (Raw(),))
    expected = NurbsModel((NurbsSurface(*unclamped()),))
    assert np.abs(expected.surfaces[0].points[0] - expected.surfaces[0].points[-1]).max() < 1e-12
    for file, text in {
        "a.json": json.dumps({"surfaces": [entry(Raw())]}), "a.igs": iges(raw), "a.stp": step(raw),
    }.items():  # fmt: skip
        (tmp_path / file).write_text(text)
        assert_same(read_nurbs(tmp_path / file), expected)


def other_separators(text):
    """The same with / between numbers and # after the last, said in section G."""
    lines = []
    for line in text.splitlines():
        if line[72:73] == "G":
            line = f"{'1H//1H#/4Htest#':<72}" + line[72:]
        if line[72:73] == "P":
            line = line[:64].replace(",", "/").replace(";", "#") + line[64:]
        lines.append(line)
    return "\n".join(lines)


def numbers_anew(text, change):
    """The same with the parameters written otherwise, folded anew."""
    lines = text.splitlines()
    rows = [line for line in lines if line[72:73] == "P"]
    words = "".join(row[:64] for row in rows).rstrip().rstrip(";").split(",")
    words = [words[0], *(change(word) for word in words[1:])]
    folded, row = [], ""
    for word in [f"{word}," for word in words[:-1]] + [f"{words[-1]};"]:
        if len(row) + len(word) > 64:  # a number is not cut in two
            folded.append(row)
            row = ""
        row += word
    folded.append(row)
    parameters = [f"{row:<64}{1:8d}P{k:7d}" for k, row in enumerate(folded, 1)]
    first = next(k for k, line in enumerate(lines) if line[72:73] == "P")
    head = lines[:first]
    second = head[-1]
    head[-1] = second[:24] + f"{len(folded):8d}" + second[32:]
    last = lines[-1].replace(f"P{len(rows):7d}", f"P{len(folded):7d}", 1)
    return "\n".join([*head, *parameters, last])


def fortran(word):
    number = float(word)
    if number.is_integer() and abs(number) < 100:
        return word
    return f"{number:+.17E}".replace("E", "")  # +1.5+00: without a letter


HOSTILE_IGES = {
    "DOS line ends and what ends a file of DOS": lambda t: t.replace("\n", "\r\n") + "\x1a",
    "old Macintosh line ends": lambda t: t.replace("\n", "\r"),
    "a byte order mark": lambda t: "\xef\xbb\xbf" + t,
    "a next line that is none": lambda t: t.replace("test ", "te\x85st", 1),
    "sequence numbers cut off": lambda t: "\n".join(line[:73] for line in t.split("\n")[:-2])
    + "\n" + t.split("\n")[-2],
    "other separators": other_separators,
    "separators left out and zeros before numbers": lambda t: re.sub(
        r"([SGDPT]) *(\d+)(?=[SGDPT ]|$)",
        lambda m: f"{m[1]}{int(m[2]):07d}",
        t.replace("1H,,1H;,4Htest;", ",,4Ht;,t,1.,02;"),
        flags=re.M,
    ),
    "a D of Fortran": lambda t: numbers_anew(t, lambda w: f"{float(w):.17E}".replace("E", "D")),
    "no letter of an exponent": lambda t: numbers_anew(t, fortran),
    "blanks around numbers": lambda t: numbers_anew(t, lambda w: f"  {w} "),
    "points after whole numbers": lambda t: numbers_anew(t, lambda w: repr(float(w))),
    "pointers to texts at the end": lambda t: (
        t[: t.rindex(";    ")] + ",0,0;" + t[t.rindex(";    ") + 5 :]
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", HOSTILE_IGES)
def test_iges_bears(tmp_path, what):
    path, model = tmp_path / "a.igs", nurbs.ball()
    path.write_bytes(HOSTILE_IGES[what](iges(model)).encode("latin-1"))
    assert_same(read_nurbs(path), model, 1e-15)


def test_iges_transformations_that_are_moved_themselves(tmp_path):
    text = iges(nurbs.ball(), matrix=[0, -1, 0, 5, 1, 0, 0, 6, 0, 0, 1, 7])
    path, (ball,) = tmp_path / "a.igs", nurbs.ball().surfaces
    lines = text.split("\n")
    at = next(k for k, line in enumerate(lines) if line.startswith("     124"))
    assert lines[at][48:56] == "       0"
    lines[at] = lines[at][:48] + "       3" + lines[at][56:]
    path.write_text("\n".join(lines))
    with pytest.raises(FileError, match="expected transformations that end, got D3 again"):
        read_nurbs(path)
    parameters = [line for line in lines if line[72:73] == "P"]
    pair = [
        lines[at][:8] + f"{len(parameters) + 1:8d}" + lines[at][16:48] + f"{0:8d}" + lines[at][56:],
        lines[at + 1],
    ]
    lines[at] = lines[at][:48] + "       5" + lines[at][56:]
    body = f"{'124,1,0,0,10,0,1,0,20,0,0,1,30;':<64}{5:8d}P{len(parameters) + 1:7d}"
    lines[at + 2 : at + 2] = pair
    lines[-2:-2] = [body]
    counted = lines[-2].replace("D      4", "D      6")
    lines[-2] = counted.replace(f"P{len(parameters):7d}", f"P{len(parameters) + 1:7d}")
    path.write_text("\n".join(lines))
    (moved,) = read_nurbs(path).surfaces
    assert moved.points == pytest.approx(ball.points[..., [1, 0, 2]] * (-1, 1, 1) + (15, 26, 37))


def folded(text):
    """The same with a line end wherever one may be."""
    head, data, rest = text.partition("DATA;")
    pieces = re.split(r"('(?:[^']|'')*'|/\*.*?\*/)", rest)
    pieces[::2] = [re.sub(r"([(),=;])", "\n\\1\n", piece) for piece in pieces[::2]]
    return head + data + "".join(pieces)


HOSTILE_STEP = {
    "DOS line ends": lambda t: t.replace("\n", "\r\n"),
    "a byte order mark": lambda t: "\xef\xbb\xbf" + t,
    "lines folded anywhere": folded,
    "comments anywhere": lambda t: t.replace(",(", ",/* ; ' ( */(").replace("= ", "=/**/"),
    "a comment within a text": lambda t: t.replace("'it''s;", "'it''s; /* "),
    "a quotation mark in the header": lambda t: t.replace("FILE_NAME('a')", "FILE_NAME('O'Brien')"),
    "a name that is a type's": lambda t: t.replace(
        "DATA;", "DATA;\n#99999=PRODUCT('B_SPLINE_SURFACE_WITH_KNOTS(','','',(#1));"
    ),
    "a named section": lambda t: t.replace("DATA;", "DATA('ONE',('A'));"),
    "small letters": lambda t: re.sub(
        r"(B_SPLINE|RATIONAL_|CARTESIAN)\w+", lambda m: m[0].lower(), t
    ),
    "numbers that end in points": lambda t: re.sub(r"(\d)\.0([,)])", r"\1.\2", t),
    "exponents": lambda t: re.sub(
        r"(?<=[(,])-?\d+\.\d+(?=[,)])", lambda m: f"{float(m[0]):.17E}", t
    ),
}


@pytest.mark.parametrize("what", HOSTILE_STEP)
def test_step_bears(tmp_path, what):
    for model in (nurbs.ball(), nurbs.quilt(1, 1, 2)):
        path, text = tmp_path / "a.stp", step(model)
        changed = HOSTILE_STEP[what](text)
        path.write_bytes(changed.encode("latin-1"))
        assert_same(read_nurbs(path), model, 1e-15)


@pytest.mark.parametrize(
    ("kind", "knots"),
    [
        ("BEZIER_SURFACE", [0, 0, 0, 1, 1, 2, 2, 2]),
        ("QUASI_UNIFORM_SURFACE", [0, 0, 0, 1, 2, 3, 3, 3]),
        ("UNIFORM_SURFACE", [-2, -1, 0, 1, 2, 3, 4, 5]),
    ],
)
def test_step_surfaces_whose_knots_follow_from_their_counts(tmp_path, kind, knots):
    random = np.random.default_rng(0)
    points, weights = random.normal(size=(5, 3, 3)), random.uniform(0.5, 2, (5, 3))
    flat = [0, 0, 0, 1, 1, 1] if kind != "UNIFORM_SURFACE" else [-2, -1, 0, 1, 2, 3]
    for given in (None, weights):
        expected = NurbsModel((NurbsSurface(2, 2, knots, flat, points, given),))
        raw = NurbsSurface(2, 2, [0, 0, 0, 1, 2, 3, 3, 3], [0, 0, 0, 1, 1, 1], points, given)
        text = step(NurbsModel((raw,)))
        number = r"\([\d.,]+\)"
        own = rf"{number},{number},{number},\n {number},\.UNSPECIFIED\."
        text = re.sub(rf",{own} \);", ");", text)  # a simple entity ends before them
        text = re.sub(rf"_WITH_KNOTS\({own}\)", "_WITH_KNOTS()", text)
        path = tmp_path / "a.stp"
        path.write_text(text.replace("B_SPLINE_SURFACE_WITH_KNOTS", kind))
        assert_same(read_nurbs(path), expected, 1e-15)
    path.write_text(path.read_text().replace(f" {kind}", " RATIONAL_B_SPLINE_SURFACE_WITH_KNOTS"))
    with pytest.raises(FileError, match="expected B-spline surfaces, got none"):
        read_nurbs(path)


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
    yield ".igs", whole.replace("128,8,4", "128,1D999,4")
    yield ".igs", whole.replace("128,8,4", "128,nan,4")
    yield ".igs", f"{'':<72}C{1:7d}\n" + whole
    text = step(nurbs.ball())
    yield from ((".stp", text[: len(text) * k // 7]) for k in range(7))
    yield ".stp", text.replace("#3 =", "#9999 =")
    yield ".stp", text.replace("_WITH_KNOTS", "")
    yield ".stp", text.replace("B_SPLINE_SURFACE(2,", "B_SPLINE_SURFACE(9,")
    yield ".stp", text.replace("B_SPLINE_SURFACE(2,", "B_SPLINE_SURFACE(")
    yield ".stp", text.replace("SURFACE() )", "SURFACE()")
    yield ".stp", text.replace("(3,2,2,2,3)", "(3,2,2,2,999999999999)")
    yield ".stp", text.replace("(3,2,2,2,3)", "(3,2,2,2e99,3)")
    yield ".stp", text.replace("it''s", "it's")
    yield ".stp", text.replace("DATA;", "DATA;" + "/*" * 50_000)
    yield ".stp", text.replace("DATA;", "DATA;'" + "a" * 50_000)


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
