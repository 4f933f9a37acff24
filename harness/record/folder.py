"""A run's folder: where it lies, its `run.json`, and when a run may be taken up again."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lodbench.datasets_gen.files import is_part
from lodbench.harness.record.environment import environment, now
from lodbench.harness.record.foreign import refuse_links
from lodbench.harness.record.record import RUN, SCHEMA, read_environment, write_json
from lodbench.harness.record.samples import check_free
from lodbench.kernels.opencl import Device

RESULTS = Path("results")


def _candidates(slug: str, commit: str) -> list[Path]:
    """Folders of runs of this device and commit, oldest first."""
    found = [path.parent for path in (RESULTS / slug).glob(f"*-{commit}*/{RUN}")]
    return sorted(found, key=lambda path: (path / RUN).stat().st_mtime)


def open_folder(
    device: Device,
    options: Mapping[str, Any],
    *,
    out: Path | None = None,
    resume: bool = False,
    seed: int = 0,
) -> Path:
    """The folder to measure into, made and described by its `run.json`: see `open_described`.

    `seed` is that of bootstrap and quality sampling.
    """
    found = environment(device, dict(options), seed)
    return open_described(found, out=out, resume=resume)


def open_described(
    environment: Mapping[str, Any], *, out: Path | None = None, resume: bool = False
) -> Path:
    """The folder to measure into, made and described by its `run.json`.

    Args:
        environment: what `environment` says of the device measured, here or elsewhere.
        out: the folder; None makes `results/<device>/<date>-<commit>/`, or takes the last one on resume.
        resume: go on with a run of the same device and commit.

    Raises:
        ValueError: the folder holds a run already, or one of another device, commit or schema.
        OSError: it cannot be made.
    """
    slug, short = str(environment["slug"]), str(environment["commit"])
    if out is None and resume:
        out = next(reversed(_candidates(slug, short)), None)
    if out is not None and (out / RUN).is_file():
        if not resume:
            raise ValueError(f"out: expected a new folder, or --resume, got the run in {out}")
        check_free(out)
        _take_up(out, slug, short)
        return out
    if out is not None and out.exists() and (not out.is_dir() or _holds_something(out)):
        raise ValueError(f"out: expected a new or empty folder, got {out}")
    if out is None:
        day = datetime.date.today().isoformat()
        first = out = RESULTS / slug / f"{day}-{short}"
        number = 2
        while not _made(out):
            out = first.with_name(f"{first.name}-{number}")
            number += 1
    out.mkdir(parents=True, exist_ok=True)
    write_json(out / RUN, {"schema": SCHEMA, **environment})
    return out


def _made(folder: Path) -> bool:
    """Make the folder; False where there is one, which may be of a run that began at the same time."""
    try:
        folder.mkdir(parents=True)
    except FileExistsError:
        return False
    return True


def _holds_something(folder: Path) -> bool:
    """More than what was left by a run that was killed before it began."""
    return not all(is_part(path) for path in folder.iterdir())


def _take_up(folder: Path, slug: str, commit: str) -> None:
    refuse_links(folder)
    found = read_environment(folder)
    for what, have, want in (
        ("device", found.get("slug"), slug),
        ("commit", found.get("commit"), commit),
    ):
        if have != want:
            raise ValueError(f"resume: expected a run of {what} {want}, got {have} in {folder}")
    found.setdefault("resumed", []).append(now())
    write_json(folder / RUN, found)
