"""The file that has the loader find Intel's runtime for CPUs: pip's package lacks a right one, so this writes it."""

from __future__ import annotations

import importlib.metadata
import importlib.util
from collections.abc import Iterator, Sequence
from pathlib import Path

from lodbench.harness.doctor.opencl import Finding, icd_files, pip

PACKAGE, LIBRARY = "intel-opencl-rt", "libintelocl.so"
NEEDED = "libimf.so"  # of intel-cmplr-lib-rt, which the package does not ask for
NAME = "intel.icd"


def _library() -> Path | None:
    """Where pip has put the driver; None where it has not."""
    try:
        files = importlib.metadata.files(PACKAGE) or []
    except importlib.metadata.PackageNotFoundError:
        return None
    found = (Path(str(file.locate())).resolve() for file in files if file.name == LIBRARY)
    return next((path for path in found if path.exists()), None)


def _named(files: Sequence[Path]) -> bool:
    """Does one of these name a driver of Intel's that is there?"""
    lines = [Path(file.read_text(errors="replace").strip()) for file in files]
    return any(line.name.startswith(LIBRARY) and line.exists() for line in lines)


def driver_file() -> Iterator[Finding]:
    """Write it beside PoCL's, where the wheel's loader looks, unless one is there; nothing without the package."""
    library = _library()
    if library is None:
        return
    if not (library.parent / NEEDED).exists():
        detail = f"{library} needs {NEEDED}, which is not beside it"
        yield Finding("Intel's runtime", "warn", detail, pip("intel-cmplr-lib-rt"))
        return
    if _named(icd_files()[0]):
        yield Finding("Intel's runtime", "ok", f"{library}, --device intel")
        return
    spec = importlib.util.find_spec("pyopencl")
    folder = Path(spec.origin).parent / ".libs" if spec and spec.origin else Path()
    try:
        (folder / NAME).write_text(f"{library}\n")
    except OSError as error:
        detail = f"{library}: no driver file names it, and none can be written: {error}"
        mend = f'd="$(mktemp -d)"; echo {library} > "$d/{NAME}"; export OCL_ICD_VENDORS="$d"'
        yield Finding("Intel's runtime", "warn", detail, mend)
        return
    yield Finding("Intel's runtime", "ok", f"{folder / NAME} was written for it: --device intel")
