"""The classic scans of the Stanford 3D Scanning Repository, downloaded once on demand."""

from __future__ import annotations

import gzip
import os
import tarfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from lodbench.datasets_gen.names import data_folders
from lodbench.datasets_gen.ply import parse_ply, ply_counts
from lodbench.datasets_gen.read import FileError, check_writable, write_mesh

_SITE = "https://graphics.stanford.edu/pub/3Dscanrep"
TERMS = "Stanford Computer Graphics Laboratory; research use, credit asked for, not for sale"


@dataclass(frozen=True)
class Scan:
    """Where a scan comes from, and the size that it must have."""

    name: str
    url: str
    member: str  # path inside the .tar.gz; empty for a .ply.gz
    vertices: int
    triangles: int


SCANS = {
    scan.name: scan
    for scan in (
        Scan(
            "bunny_69k",
            f"{_SITE}/bunny.tar.gz",
            "bunny/reconstruction/bun_zipper.ply",
            35_947,
            69_451,
        ),
        Scan("armadillo_346k", f"{_SITE}/armadillo/Armadillo.ply.gz", "", 172_974, 345_944),
        Scan(
            "dragon_871k",
            f"{_SITE}/dragon/dragon_recon.tar.gz",
            "dragon_recon/dragon_vrip.ply",
            437_645,
            871_414,
        ),
        Scan(
            "buddha_1088k",
            f"{_SITE}/happy/happy_recon.tar.gz",
            "happy_recon/happy_vrip.ply",
            543_652,
            1_087_716,
        ),
    )
}


def fetch(name: str, say: Callable[[str], None] | None = None) -> Path:
    """Path of a scan as PLY in the first of `data_folders()`, downloaded if it is not there yet.

    No checksum is published for these files, so none is checked: the numbers of vertices and triangles must
    be the published ones, and every index must be in range. `say` gets one line before and after.

    Raises:
        FileError: an unknown name, no pooch, no network, no room, or a file that is not the scan.
    """
    if name not in SCANS:
        raise FileError(f"dataset: expected one of {' '.join(SCANS)}, got {name!r}")
    scan = SCANS[name]
    say = say or (lambda line: None)
    folder = data_folders()[0] / "meshes"
    target = folder / f"{name}.ply"
    if target.is_file():
        return target
    try:
        import pooch
    except ImportError:
        raise FileError(
            f"{name}: downloading needs pooch: pip install 'lodbench[datasets]'"
        ) from None
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"{folder}: cannot be made: {error.strerror}") from None
    check_writable(target)
    say(
        f"{name}: downloading {scan.url} ({TERMS}); no checksum is published, "
        f"so the counts are checked: {scan.vertices:,} vertices, {scan.triangles:,} triangles"
    )
    pooch.get_logger().setLevel("ERROR")
    try:
        archive = Path(
            pooch.retrieve(
                scan.url, known_hash=None, path=folder, fname=f".{name}.{os.getpid()}.part"
            )
        )
    except Exception as error:  # requests, urllib3 and the system each have their own
        why = " ".join(str(error).split())[:200]
        raise FileError(f"{name}: cannot be downloaded from {scan.url} (offline?): {why}") from None
    try:
        write_mesh(target, _checked(scan, archive))
    finally:
        archive.unlink(missing_ok=True)
    say(f"{name}: {target}")
    return target


def _checked(scan: Scan, archive: Path):
    """The mesh in a downloaded archive, if it is the scan."""
    try:
        if scan.member:
            with tarfile.open(archive) as files:
                stream = files.extractfile(scan.member)
                data = stream.read() if stream else b""
        else:
            data = gzip.decompress(archive.read_bytes())
        counts = ply_counts(data)
        if counts != (scan.vertices, scan.triangles):
            raise ValueError(
                f"expected {scan.vertices} vertices and {scan.triangles} triangles, got {counts}"
            )
        return parse_ply(data)
    except (OSError, EOFError, KeyError, ValueError, tarfile.TarError) as error:
        why = " ".join(str(error).split())[:200]
        raise FileError(f"{scan.name}: {scan.url} is not the scan: {why}") from error
