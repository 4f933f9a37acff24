"""What is fuzzed: every system that runs on a device, and every reader of files; one call per input.

A call ends in a result that is checked, in a refusal (an error that says what was expected, or what the device
lacks), or it is a loss.
"""

import io
import json
import tempfile
import zipfile
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from hypothesis import strategies as st

from lodbench.datasets_gen import contents
from lodbench.datasets_gen.formats import WRITERS
from lodbench.datasets_gen.height_maps import height_map
from lodbench.datasets_gen.images import geometry_image_bytes, read_geometry_image
from lodbench.datasets_gen.nurbs import ball
from lodbench.datasets_gen.nurbs_files import read_nurbs
from lodbench.datasets_gen.nurbs_surface import NurbsModel
from lodbench.datasets_gen.patches import cup, read_patches
from lodbench.datasets_gen.read import FileError, parse_mesh
from lodbench.datasets_gen.surfaces import BezierPatches, GeometryImage, TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.plan import sweep
from lodbench.harness.plan.registry import systems
from lodbench.harness.record.record import RUN, SAMPLES, read_run
from lodbench.kernels.opencl import Device
from lodbench.kernels.opencl.driver import Unsupported
from lodbench.kernels.system import run
from tests.datasets_gen.test_nurbs_files import iges, step
from tests.fuzz import inputs
from tests.harness.made_run import make_run

SIZES = {
    "segments": 16,
    "level": 3,
}  # of a case in nine of ten inputs: the time goes into points otherwise
MAKERS = {
    TriangleMesh: (inputs.meshes, inputs.mesh),
    BezierPatches: (inputs.surfaces, inputs.patches),
    NurbsModel: (inputs.surfaces, inputs.nurbs),
}


class Wrong(Exception):
    """A result that no caller should get."""


@dataclass(frozen=True)
class Target:
    """`call` takes what `strategy` draws, and returns "ok" or raises."""

    name: str
    strategy: st.SearchStrategy
    call: object


def check_mesh(mesh):
    """Raise unless every point is finite and every index in range."""
    if not np.isfinite(mesh.positions).all():
        raise Wrong("a point that is not finite")
    if mesh.triangle_count and int(mesh.triangles.max()) >= mesh.vertex_count:
        raise Wrong("an index out of range")


@cache
def _device():
    return Device.open()


def small(params):
    """The same parameters with every size at most that of `SIZES`; as they are where others depend on it."""
    changed = {
        key: min(getattr(params, key), most)
        for key, most in SIZES.items()
        if isinstance(getattr(params, key, None), int)
    }
    try:
        return replace(params, **changed)
    except ValueError:
        return params


def _system(name):
    system = systems()[name]
    strategy, make = next(found for kind, found in MAKERS.items() if kind in system.takes)

    def call(description):
        surface = make(description["surface"])
        params = system.cases[description["case"]]
        params = small(params) if description["size"] else params
        prepared = system.prepare(_device(), surface, params)
        run(_device(), prepared)
        for mesh in prepared.result():
            check_mesh(mesh)
        return "ok"

    whole = {
        "surface": strategy,
        "case": st.sampled_from(list(system.cases)),
        "size": st.integers(0, 9),
    }
    return Target(name, st.fixed_dictionaries(whole), call)


def _wholes():
    """Reader -> a few right files of its kind, and what reads the bytes of one."""
    balls = [icosphere(level) for level in (0, 1)]
    folder = Path(tempfile.mkdtemp(prefix="lodbench-fuzz-"))

    def mesh_reader(suffix):
        return lambda data: check_mesh(parse_mesh(data, Path(f"x{suffix}")))

    def of_file(read, suffix):
        path = folder / f"x{suffix}"

        def call(data):
            path.write_bytes(data)
            read(path)

        return call

    found = {
        f"mesh{suffix}": ([write(ball) for ball in balls], mesh_reader(suffix))
        for suffix, write in WRITERS.items()
    }
    text = "1\n3 3\n" + "\n".join(" ".join(map(str, p)) for p in cup().points[0].reshape(16, 3))
    found["patches.npz"] = _archive({"patches": cup().points[:3]}, of_file(read_patches, ".npz"))
    found["patches.bpt"] = ([text.encode()], of_file(read_patches, ".bpt"))
    (one,) = ball().surfaces
    model = {
        "degree_u": one.degree_u, "degree_v": one.degree_v, "knots_u": one.knots_u.tolist(),
        "knots_v": one.knots_v.tolist(), "control_points": one.points.tolist(), "weights": one.weights.tolist(),
    }  # fmt: skip
    found["nurbs.json"] = (
        [json.dumps({"surfaces": [model]}).encode()],
        of_file(read_nurbs, ".json"),
    )
    for suffix, text in ((".igs", iges(ball())), (".stp", step(ball()))):
        found[f"nurbs{suffix}"] = ([text.encode()], of_file(read_nurbs, suffix))
    rng = np.random.default_rng(0)
    image = GeometryImage(rng.normal(size=(9, 9, 3)), np.ones((9, 9, 3)))
    with np.load(io.BytesIO(geometry_image_bytes(image))) as arrays:
        found["geometry_image.npz"] = _archive(dict(arrays), of_file(read_geometry_image, ".npz"))
    grid = io.BytesIO()
    np.save(grid, rng.random((5, 7), np.float32))
    found["height_map.npy"] = ([grid.getvalue()], of_file(height_map, ".npy"))
    made = make_run(folder / "run")
    for name in (RUN, SAMPLES):
        found[f"record/{name}"] = ([(made / name).read_bytes()[:6000]], _record(made, name))
    toml = (
        b'systems = ["quadric_clustering"]\ndatasets = ["icosphere_3"]\n[params]\ncells = [8, 16]\n'
    )
    found["sweep.toml"] = ([toml], of_file(sweep.read, ".toml"))
    found["contents"] = ([write(balls[0]) for write in WRITERS.values()], contents.format_of)
    return found


def _archive(arrays, read):
    """Each array as a file of its own, which is damaged and put into an archive with the others: its sums are right."""
    whole = {}
    for name, array in arrays.items():
        np.save(file := io.BytesIO(), array)
        whole[name] = file.getvalue()
    names = list(whole)

    def call(data):
        which = names[data[0] % len(names)]
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w") as archive:
            for name in names:
                archive.writestr(f"{name}.npy", data[1:] if name == which else whole[name])
        read(packed.getvalue())

    return [bytes([i]) + whole[name] for i, name in enumerate(names)], call


def _record(folder, name):
    whole = (folder / name).read_bytes()

    def call(data):
        try:
            (folder / name).write_bytes(data + (whole[6000:] if name == RUN else b""))
            read_run(folder)
        finally:
            (folder / name).write_bytes(whole)

    return call


@cache
def _readers():
    found = {}
    for name, (wholes, read) in _wholes().items():

        def call(description, wholes=wholes, read=read):
            whole = wholes[description["whole"] % len(wholes)]
            read(inputs.damaged(whole, description["edits"]) or whole[:1])
            return "ok"

        found[name] = Target(name, inputs.files, call)
    return found


def names():
    """The names of all targets, (systems, readers)."""
    kernels = [
        name
        for name, system in systems().items()
        if system.runs_on == "device" and system.family != "baselines"
    ]
    return kernels, list(_readers())


def target(name):
    """The target of this name."""
    return _system(name) if name in systems() else _readers()[name]


def outcome(target, description):
    """ok, refused, or what was lost: `wrong ...`, `fault ...`."""
    try:
        return target.call(description)
    except (ValueError, TypeError) as error:
        text = " ".join(str(error).split())
        said = isinstance(error, FileError) or "expected" in text
        return "refused" if said else f"fault {type(error).__name__}: {text[:200]}"
    except Unsupported:
        return "refused"
    except Wrong as wrong:
        return f"wrong {wrong}"
    except Exception as error:
        return f"fault {type(error).__name__}: {' '.join(str(error).split())[:200]}"
