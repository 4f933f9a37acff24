"""The tables behind the catalogue: generated shapes of any size, and what stands in for which scan."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from lodbench.datasets_gen import nurbs, patches, shapes, triangles
from lodbench.datasets_gen.surfaces import BezierPatches, NurbsModel, TriangleMesh

Sized = tuple[int | None, Callable[[], TriangleMesh]]
"""The exact number of triangles, where known beforehand, and what makes them."""


def _geodesic(make: Callable[[int], TriangleMesh], count: int) -> Sized:
    segments = max(1, round((count / 20) ** 0.5))
    return 20 * segments**2, partial(make, segments)


def _displaced(count: int) -> Sized:
    """At most 31 segments subdivided further, so that every size has the order of recursion."""
    segments = max(1, round((count / 20) ** 0.5))
    step = 1 << max(0, segments.bit_length() - 5)
    segments = round(segments / step) * step
    return 20 * segments**2, partial(triangles.displaced_icosphere, segments)


def _square(make: Callable[[int], TriangleMesh], count: int) -> Sized:
    columns = max(1, round((count / 2) ** 0.5))
    return 2 * columns**2, partial(make, columns)


def _torus(count: int) -> Sized:
    across = max(3, round((count / 4) ** 0.5))
    return 4 * across**2, partial(triangles.torus, 2 * across, across)


def _sphere(count: int) -> Sized:
    count = max(6, count + count % 2)
    return count, partial(triangles.sphere, count)


def _spool(count: int) -> Sized:
    slices = max(6, round((count / 2) ** 0.5))
    return 2 * slices**2, partial(shapes.spool, slices)


def _plate(genus: int, sharp: bool, count: int) -> Sized:
    columns = int(np.ceil(np.sqrt(max(genus, 1))))
    rows = -(-max(genus, 1) // columns)
    quads, rim = 9 * rows * columns - genus, 6 * (rows + columns) + 4 * genus  # times b^2 and b
    # the positive root of 4 quads b^2 + 2 rim b = count
    block = max(1, round(((rim**2 + 4 * quads * count) ** 0.5 - rim) / (4 * quads)))
    return 4 * quads * block**2 + 2 * rim * block, partial(shapes.plate, block, genus, sharp)


def _scan_like(genus: int, holes: int, count: int) -> Sized:
    """Bumpy and closed, or with holes: of the topology of a scan."""
    total, make = _plate(genus, False, count) if genus else _geodesic(shapes.blob_with_ears, count)
    if not holes:
        return total, lambda: shapes.bumpy(make())
    return None, lambda: shapes.pierced(shapes.bumpy(make()), holes)


def _parted(parts: int, count: int) -> Sized:
    """So many closed parts that lie in each other."""
    segments = max(1, round((count / parts / 20) ** 0.5))
    make = partial(shapes.blob_with_ears, segments)

    def made() -> TriangleMesh:
        one = make()
        angles = 2 * np.pi * np.arange(parts) / parts
        middles = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(parts)])
        size = float(np.ptp(one.positions, axis=0).max())
        points = one.positions[None] + (0.8 * size * middles[:, None]).astype(np.float32)
        steps = one.vertex_count * np.arange(parts, dtype=np.uint32)
        faces = one.triangles[None] + steps[:, None, None]
        return TriangleMesh(points.reshape(-1, 3), faces.reshape(-1, 3))

    return parts * 20 * segments**2, made


SHAPES: dict[str, tuple[Callable[[int], Sized], str]] = {
    "torus": (_torus, "closed, genus 1, exact normals"),
    "sphere": (_sphere, "closed, slices and stacks, exactly so many triangles, exact normals"),
    "geodesic_sphere": (partial(_geodesic, triangles.geodesic_sphere), "closed, row by row"),
    "displaced_icosphere": (
        _displaced,
        "closed, two sine displacements, one surface at every size, exact normals",
    ),
    "blob_with_ears": (partial(_geodesic, shapes.blob_with_ears), "closed, not star-shaped"),
    "bumpy_blob": (partial(_scan_like, 0, 0), "closed, genus 0, rough as a scan"),
    "open_blob": (partial(_scan_like, 0, 5), "five holes, rough as a scan"),
    "plate_1_hole": (partial(_plate, 1, False), "closed, genus 1, round rims"),
    "plate_6_holes": (partial(_plate, 6, False), "closed, genus 6, round rims"),
    "part_3_holes": (partial(_plate, 3, True), "closed, genus 3, flat faces and sharp edges"),
    "spool": (_spool, "closed, genus 0, two rims tagged as creases"),
    "plane": (partial(_square, triangles.plane), "open, flat: no error, many ties"),
    "terrain": (partial(_square, triangles.terrain), "open height field, one surface at every size"),
}  # fmt: skip

SCANS: dict[str, Callable[[], Sized]] = {
    "bunny_69k": lambda: _scan_like(0, 5, 69_451),
    "bunny_closed_70k": lambda: _scan_like(0, 0, 69_630),
    "armadillo_29k": lambda: _scan_like(0, 0, 29_170),
    "armadillo_86k": lambda: _scan_like(0, 0, 86_482),
    "armadillo_346k": lambda: _scan_like(0, 0, 345_944),
    "dragon_100k": lambda: _scan_like(1, 0, 100_000),
    "dragon_871k": lambda: _scan_like(1, 0, 871_414),
    "buddha_100k": lambda: _scan_like(6, 0, 100_000),
    "buddha_1088k": lambda: _scan_like(6, 0, 1_087_716),
    "koala_100k": lambda: _scan_like(0, 0, 99_994),
    "kitten_g1": lambda: _scan_like(1, 0, 25_246),
    "fertility_g4": lambda: _scan_like(4, 0, 9_000),
    "spot": lambda: _scan_like(0, 0, 5_856),
    "camelhead_open": lambda: _scan_like(0, 1, 22_704),
    "beetle_open": lambda: _scan_like(0, 11, 38_656),
    "mountain_od": lambda: _square(triangles.terrain, 50_562),
    "fandisk": lambda: _plate(0, True, 12_946),
    "mechpart_g3": lambda: _plate(3, True, 15_232),
    "rocker_arm": lambda: _plate(1, True, 20_088),
    "threeholes_g3": lambda: _plate(3, False, 7_200),
    "cessna_11comp": lambda: _parted(11, 13_546),
}
PATCHES: dict[str, tuple[Callable[[], BezierPatches], str]] = {
    "pot_32": (partial(patches.pot, 8), "32 patches, closed, collapsed edges at the poles"),
    "cup_26": (patches.cup, "26 patches, open, with a handle"),
    "pot_128": (partial(patches.pot, 32), "128 patches, closed, collapsed edges at the poles"),
    "teapot_standin": (partial(patches.pot, 8), "in place of teapot: 32 patches"),
    "teacup_standin": (patches.cup, "in place of teacup: 26 patches"),
    "teaspoon_standin": (partial(patches.pot, 4), "in place of teaspoon: 16 patches"),
    "elephant_gumbo_standin": (partial(patches.pot, 32), "in place of elephant_gumbo: 128 patches"),
}
NURBS: dict[str, tuple[Callable[[], NurbsModel], str]] = {
    "rational_cylinder": (nurbs.cylinder, "1 rational surface 2 x 1: an exact cylinder"),
    "rational_ball": (nurbs.ball, "1 rational surface 2 x 2: an exact sphere"),
    "rational_torus": (nurbs.torus, "1 rational surface 2 x 2: an exact torus"),
    "mixed_degrees": (nurbs.mixed_degrees, "7 rational surfaces of degrees 1 to 7"),
    "bicubic_12": (partial(nurbs.quilt, 1, 1, 9), "1 bicubic surface of 12 x 12 control points"),
    "quilt_4": (partial(nurbs.quilt, 2, 2, 8), "4 bicubic surfaces, 256 knot spans"),
    "random_spans": (nurbs.random_spans, "25 surfaces, 10,000 knot spans, all at random"),
    "killeroo_standin": (nurbs.body, "in place of killeroo: 88 bicubic surfaces, closed"),
    **{
        f"sheets_degree_{p}": (partial(nurbs.sheets, p), f"256 surfaces of degree {p} x {p}")
        for p in range(1, 8)
    },
}
