"""What the fuzzer feeds: small descriptions that hypothesis draws, and the surface or file that each of them makes.

A description is plain JSON, so that a loss can be written down and made again.
"""

import base64
import json

import numpy as np
from hypothesis import strategies as st

from lodbench.datasets_gen.nurbs import ball, cylinder
from lodbench.datasets_gen.nurbs_surface import NurbsModel, NurbsSurface
from lodbench.datasets_gen.surfaces import BezierPatches, TriangleMesh
from lodbench.datasets_gen.triangles import icosphere

ODD = (
    0.0,
    -0.0,
    1e-30,
    -1e-30,
    1e30,
    -1e30,
    1.0,
    np.nextafter(np.float32(1), np.float32(2)),
    16777217.0,
)
DAMAGES = (
    "none",
    "duplicates",
    "flips",
    "collapsed",
    "no_area",
    "one_plane",
    "one_line",
    "one_point",
    "odd",
    "unused",
)

meshes = st.fixed_dictionaries(
    {
        "kind": st.sampled_from(["soup", "ball", "fan", "strip"]),
        "seed": st.integers(0, 2**32 - 1),
        "triangles": st.integers(0, 40),
        "vertices": st.integers(1, 30),
        "exponent": st.integers(-30, 30),
        "offset": st.sampled_from([0.0, 1.0, -1e3, 1e6]),
        "damages": st.lists(st.sampled_from(DAMAGES), max_size=3),
    }
)
surfaces = st.fixed_dictionaries(
    {
        "seed": st.integers(0, 2**32 - 1),
        "count": st.integers(0, 4),
        "exponent": st.integers(-30, 30),
        "offset": st.sampled_from([0.0, 1.0, -1e3, 1e6]),
        "damages": st.lists(st.sampled_from(DAMAGES), max_size=3),
    }
)


def _placed(points, rng, shape):
    """Points damaged, scaled and moved as the description says; all stay finite in float32."""
    for damage in shape["damages"]:
        if not len(points):
            break
        if damage == "one_plane":
            points[..., 2] = points.reshape(-1, 3)[0, 2]
        elif damage == "one_line":
            points[..., 1:] = points.reshape(-1, 3)[0, 1:]
        elif damage == "one_point":
            points[:] = points.reshape(-1, 3)[0]
        elif damage == "odd":
            return np.where(rng.random(points.shape) < 0.3, rng.choice(ODD, points.shape), points)
    scale = 10.0 ** shape["exponent"]
    return np.clip(points * scale + shape["offset"] * scale, -1e30, 1e30)


def mesh(shape):
    """The TriangleMesh of a description."""
    rng = np.random.default_rng(shape["seed"])
    n, m = shape["vertices"], shape["triangles"]
    if shape["kind"] == "ball":
        whole = icosphere(m % 3)
        points, faces = whole.positions.astype(float), whole.triangles.astype(int)
    elif shape["kind"] == "fan":  # all triangles share an edge: no manifold
        points = rng.normal(size=(m + 2, 3))
        faces = np.column_stack([np.zeros(m), np.ones(m), np.arange(m) + 2]).astype(int)
    elif shape["kind"] == "strip":
        points = np.column_stack([np.arange(m + 2), np.arange(m + 2) % 2, rng.normal(size=m + 2)])
        faces = np.arange(m)[:, None] + [0, 1, 2]
    else:
        points = rng.normal(size=(n, 3))
        faces = rng.integers(0, n, (m, 3))
    for damage in shape["damages"]:
        if not len(faces):
            break
        some = rng.random(len(faces)) < 0.4
        if damage == "duplicates":
            faces = np.concatenate([faces, faces[some]])
        elif damage == "flips":
            faces[some] = faces[some][:, ::-1]
        elif damage == "collapsed":
            faces[some, 1] = faces[some, 0]
        elif damage == "no_area":
            points[faces[0, 2]] = (points[faces[0, 0]] + points[faces[0, 1]]) / 2
        elif damage == "unused":
            points = np.concatenate([points, rng.normal(size=(3, 3))])
    return TriangleMesh(_placed(points, rng, shape), faces)


def patches(shape):
    """The BezierPatches of a description."""
    rng = np.random.default_rng(shape["seed"])
    points = rng.normal(size=(shape["count"], 4, 4, 3))
    if "duplicates" in shape["damages"]:
        points = np.concatenate([points, points])
    if "collapsed" in shape["damages"]:
        points[:, :, 0] = points[:, :1, 0]
    return BezierPatches(_placed(points, rng, shape))


def nurbs(shape):
    """The NurbsModel of a description."""
    rng = np.random.default_rng(shape["seed"])
    found = []
    for number in range(shape["count"]):
        (one,) = (ball() if number % 2 else cylinder()).surfaces
        points = one.points + rng.normal(scale=0.3, size=one.points.shape)
        weights = one.weights * rng.uniform(1e-3, 1e3, one.weights.shape)
        found.append(
            NurbsSurface(
                one.degree_u,
                one.degree_v,
                one.knots_u,
                one.knots_v,
                _placed(points, rng, shape),
                weights,
            )
        )
    return NurbsModel(tuple(found))


WORDS = (
    b"nan",
    b"inf",
    b"-1",
    b"99999999999",
    b"1e400",
    b"",
    b"0",
    b"\x00",
    b"\xff\xff\xff\xff",
    b" ",
    b"\n",
    b"{",
    b"]",
    b"-0.0",
)
edits = st.lists(
    st.tuples(
        st.sampled_from(["flip", "cut", "repeat", "word", "number", "noise", "end"]),
        st.integers(0, 2**31 - 1),
        st.integers(0, 2**31 - 1),
    ),
    min_size=0,
    max_size=6,
)
files = st.fixed_dictionaries({"whole": st.integers(0, 3), "edits": edits})


def damaged(whole, how):
    """`whole`, the bytes of a right file, after edits of [what, where, value]."""
    data = bytearray(whole)
    for what, where, value in how:
        at = where % (len(data) + 1)
        if what == "flip" and data:
            data[at % len(data)] ^= 1 << value % 8
        elif what == "cut":
            del data[at : at + 1 + value % 64]
        elif what == "repeat":
            data[at:at] = data[at : at + 1 + value % 64]
        elif what == "word":
            data[at:at] = WORDS[value % len(WORDS)]
        elif what == "noise":
            data[at : at + 4] = value.to_bytes(4, "little")
        elif what == "end":
            del data[at:]
        elif what == "number":  # one that stands there in text becomes another
            start = next((i for i in range(at, len(data)) if chr(data[i]).isdigit()), None)
            if start is not None:
                stop = next(
                    (i for i in range(start, len(data)) if not chr(data[i]).isdigit()), len(data)
                )
                data[start:stop] = WORDS[value % 7]
    return bytes(data)


def written(description, data=None):
    """A description as one line of text, with the bytes that it made."""
    more = {} if data is None else {"bytes": base64.b64encode(data).decode()}
    return json.dumps({**description, **more})
