"""The standard names, and where real models lie; imports little, so that the tab key answers at once."""

from __future__ import annotations

import os
from pathlib import Path

from lodbench.datasets_gen.files import cache_folder

SIZED = (
    "torus_20k", "torus_1m", "sphere_10", "sphere_100", "sphere_1000",
    *(f"icosphere_{level}" for level in range(9)),
    "displaced_icosphere_20k", "displaced_icosphere_20k_sorted",
    "displaced_icosphere_100k", "displaced_icosphere_100k_sorted",
    "displaced_icosphere_330k", "displaced_icosphere_330k_sorted",
    "displaced_icosphere_1310k", "displaced_icosphere_1310k_sorted",
    "displaced_icosphere_10m", "displaced_icosphere_10m_sorted",
    "blob_with_ears_20k", "blob_with_ears_100k", "bumpy_blob_100k", "open_blob_100k",
    "plate_1_hole_20k", "plate_6_holes_100k", "part_3_holes_20k", "spool_162",
    "plane_2k", "plane_200k", "terrain_2k", "terrain_50k", "terrain_2m", "terrain_2m_sorted",
)  # fmt: skip
SCANS = (
    "bunny_69k", "bunny_closed_70k", "armadillo_29k", "armadillo_86k", "armadillo_346k",
    "dragon_100k", "dragon_871k", "buddha_100k", "buddha_1088k", "koala_100k", "kitten_g1",
    "fertility_g4", "spot", "camelhead_open", "beetle_open", "mountain_od", "fandisk",
    "mechpart_g3", "rocker_arm", "threeholes_g3", "cessna_11comp",
)  # fmt: skip
PATCHES = (
    "pot_32", "cup_26", "pot_128", "teapot_standin", "teacup_standin", "teaspoon_standin",
    "elephant_gumbo_standin",
)  # fmt: skip
NURBS = (
    "rational_cylinder", "rational_ball", "rational_torus", "mixed_degrees", "bicubic_12",
    "quilt_4",
    "random_spans",
    "killeroo_standin",
    *(f"sheets_degree_{degree}" for degree in range(1, 8)),
)  # fmt: skip
FOLDERS = {
    "meshes": (".ply", ".obj", ".stl", ".off", ".gltf", ".glb"),
    "nasty": (".ply", ".obj", ".stl", ".off", ".gltf", ".glb"),
    "bezier": (".npz", ".bpt"),
    "nurbs": (".json", ".igs", ".iges", ".stp", ".step"),
}
"""Folder of real models -> suffixes, best first."""


def data_folders() -> list[Path]:
    """Where real models are looked for: LODBENCH_DATA if it is set, then the user's cache folder."""
    given = os.environ.get("LODBENCH_DATA")
    return [*([Path(given)] if given else []), cache_folder() / "data"]


def standard_names() -> list[str]:
    """Every name that `catalogue.names()` gives, in no order; nothing is read."""
    models = {
        path.stem
        for root in data_folders()
        for folder, suffixes in FOLDERS.items()
        if (root / folder).is_dir()
        for path in (root / folder).iterdir()
        if path.suffix.lower() in suffixes
    }
    standins = (f"{scan}_standin" for scan in SCANS)
    return sorted({*SIZED, *PATCHES, *NURBS, *models, *standins})
