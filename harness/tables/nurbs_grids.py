"""NURBS surfaces on uniform grids against packages of arrays, Bezier patches and a real vertex shader."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lodbench.harness.plan.group import Draw, Group, Subject
from lodbench.harness.plan.table import (
    STATUS_COLUMNS,
    WALL_COLUMNS,
    Column,
    Entry,
    Row,
    Table,
    ratio_columns,
)
from lodbench.kernels.bezier.lattice import side_vertices
from lodbench.kernels.stages.camera import TABLE_SIZE
from lodbench.kernels.subject import POINT

MODELS = ("killeroo", "aorta_valve", "hammer_nd", "nacelle", "ducky", "aircraft_wing")
WHOLE = Draw(TABLE_SIZE)
GENERATED = ("rational_ball", "mixed_degrees")
ONE = "bicubic_12"
PEERS = ("numpy_nurbs", "splipy_nurbs", "scipy_ndbspline")
SLOW = "geomdl_nurbs"
BEZIER, SHADER = "nurbs_as_bezier", "gl_nurbs"
NORMALS, ONE_CORE = "with_normals", "one_core"
FILL = "device_fill"
SPAN_LEVEL = 3
DRAWN = "drawn"


def _against(dataset: str, peer: str, *subjects: Subject, **facts: Any) -> Group:
    """Ours and one peer alone, so that nothing but the two takes the caches and the cores."""
    facts = {**facts, "against": peer}
    return Group(dataset, subjects, facts, standin_ok=dataset == "killeroo", warm=True)


def _groups(dataset: str, level: int, peers: Sequence[str]) -> list[Group]:
    """Grids of whole surfaces: ours and each peer, then ours by itself."""
    size: dict[str, Any] = {"level": level}
    points = {**size, "normals": False}
    stair = Subject("uniform_nurbs", points, "stair")
    itself = (
        Subject("uniform_nurbs", size, NORMALS),
        Subject("uniform_nurbs", points, ONE_CORE, one_core=True),
    )
    made = [_against(dataset, peer, stair, Subject(peer, size), **size) for peer in peers]
    return [*made, _against(dataset, "itself", stair, *itself, **size)]


def _filled(dataset: str, level: int) -> Group:
    """One surface's points, and as many bytes filled."""
    size: dict[str, Any] = {"level": level}
    fill = Subject(FILL, {"size_bytes": POINT * side_vertices(level) ** 2})
    stair = Subject("uniform_nurbs", size | {"normals": False}, "stair")
    return _against(dataset, FILL, stair, fill, **size)


def _spans(dataset: str) -> list[Group]:
    """A grid on each KSQuad: ours, these as Bezier patches, and a driver's vertex shader, without and with drawing."""
    size: dict[str, Any] = {"level": SPAN_LEVEL}
    ours, points = {**size, "per": "span"}, {"normals": False}
    image = {**size, "width": TABLE_SIZE[0], "height": TABLE_SIZE[1]}
    pairs = (
        ("", Subject("uniform_nurbs", ours | points, "stair"), Subject(BEZIER, size | points)),
        (
            "",
            Subject("uniform_nurbs", ours, NORMALS),
            Subject(SHADER, {**size, "output": "points"}),
        ),
        (DRAWN, Subject("uniform_nurbs", ours, NORMALS, draw=WHOLE), Subject(SHADER, image)),
    )
    return [
        _against(dataset, theirs.name, own, theirs, **size, per="KSQuad", work=work)
        for work, own, theirs in pairs
    ]


def groups(quick: bool) -> list[Group]:
    """One bicubic surface, large; then models, those that are there; `quick` has the first and a few generated ones."""
    from lodbench.datasets_gen import catalogue

    there = catalogue.names("nurbs")
    found = [name for name in MODELS if name in there] or [MODELS[0]]
    large = 9 if quick else 10
    made = [*_groups(ONE, large, PEERS), _filled(ONE, large)]
    made += _groups(ONE, 5, (*PEERS, SLOW))
    for name in GENERATED if quick else (*found, *GENERATED):
        made += _groups(name, 5, PEERS)
    return made + [one for name in ((ONE,) if quick else (ONE, found[0])) for one in _spans(name)]


def own(entry: Entry) -> Mapping[str, Any]:
    """Points per second; where a sample is a whole frame, frames."""
    row = entry.row
    vertices, wall = row["vertices_out"], row["wall_s"]
    more: Row = {"driver": entry.subject.driver} if entry.subject.driver else {}
    if not vertices or not wall:
        return more
    return more | (
        {"frame_fps": 1 / wall} if row.get("work") == DRAWN else {"vertices_per_s": vertices / wall}
    )


TABLE = Table(
    id="nurbs_grids",
    title="NURBS surfaces on uniform grids",
    source="Concheiro 2013, section 6.2 and figure 6.4a; peers: NumPy, splipy, SciPy, geomdl",
    groups=groups,
    own=own,
    columns=(
        Column("dataset", "dataset", brief=True),
        Column("surfaces", "surfaces"),
        Column("quads", "KSQuads"),
        Column("level", "L", brief=True),
        Column("per", "for each"),
        Column("work", "work"),
        Column("against", "against"),
        Column("system", "subject", brief=True),
        *WALL_COLUMNS,
        Column("stage_s", "device time", "s"),
        Column("basis_s", "basis functions", "s", brief=True),
        Column("vertices_out", "points", brief=True),
        Column("vertices_per_s", "points per second", "1/s", brief=True),
        Column("frame_fps", "frame fps", "1/s"),
        *ratio_columns(
            (*PEERS, SLOW, BEZIER, SHADER, ONE_CORE, FILL), shown=(*PEERS, BEZIER, SHADER)
        ),
        Column("driver", "driver"),
        *STATUS_COLUMNS,
    ),
    notes=(
        "A surface has 2^L segments along each side; where it says KSQuad, each of these has. Points alone, but for "
        "with_normals. NumPy's matrices of basis functions are made before its clock starts, those of the kernels in "
        "every frame.",
        "nurbs_as_bezier has cut the surfaces into Bezier patches beforehand, whose vertices they share with none; "
        "bicubic surfaces without weights alone. gl_nurbs is a driver's vertex shader, which makes basis functions and "
        "sums at every vertex; it keeps points and normals, or draws, and then ours draws too.",
        "device_fill writes as many bytes as the points have and computes nothing: nothing that makes them is faster.",
        "Each peer takes turns with ours alone, in a group of two: where several share a group, each finds the caches "
        "full of the others' points and the cores asleep or still held by others' threads. "
        "Every sample, ours or a peer's, follows at once on frames of the same subject that are not timed.",
    ),
)
