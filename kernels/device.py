"""Open a device, build programs, hold buffers, launch kernels by name: the only file that speaks to pyopencl."""

from __future__ import annotations

import hashlib
import json
import os
import re
import tempfile
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lodbench.kernels.stages.timeline import Timeline

KERNELS = Path(__file__).parent
PRELUDE = "common/prelude.cl"
LOCAL_SIZE = 64  # one fixed size: the driver's own choice would compile anew for every mesh size


class Unsupported(RuntimeError):
    """This device cannot do what was asked: "needs ..., device has ..."."""


class DeviceError(RuntimeError):
    """The driver refused or failed; the text says what to look at."""


def _opencl() -> Any:
    """pyopencl, imported when a device is first wanted and never before."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import pyopencl
    warnings.filterwarnings("ignore", category=pyopencl.CompilerWarning)
    return pyopencl


def cache_folder() -> Path:
    """Where small facts about devices and set-ups are kept; `LODBENCH_CACHE` moves it."""
    default = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "lodbench"
    return Path(os.environ.get("LODBENCH_CACHE") or default)


def write_cache(path: Path, text: str) -> None:
    """Write `text` so that a reader sees all of it or nothing; a cache that cannot be written is no error."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile("w", dir=path.parent, delete=False) as file:
            file.write(text)
        os.replace(file.name, path)
    except OSError:
        pass


@dataclass(frozen=True)
class DeviceFacts:
    """What a record must say of the device it ran on."""

    name: str
    platform: str
    driver: str
    version: str
    kind: str
    compute_units: int
    memory_bytes: int
    largest_allocation_bytes: int
    local_bytes: int
    extensions: tuple[str, ...]
    one_core: bool
    builtins_ratio: float
    prelude: bool


@dataclass(eq=False)
class Buffer:
    """Device memory of one array, with the name, shape and dtype that a kernel's argument is checked against."""

    name: str
    shape: tuple[int, ...]
    dtype: np.dtype
    memory: Any
    _release: Callable[[int], None]

    @property
    def size_bytes(self) -> int:
        return max(int(np.prod(self.shape, dtype=np.int64)) * self.dtype.itemsize, 1)

    def release(self) -> None:
        """Give the memory back to the device's pool."""
        if self.memory is not None:
            self.memory.release()
            self.memory = None
            self._release(self.size_bytes)

    def __del__(self) -> None:
        try:
            self.release()
        except Exception:  # the interpreter or the driver is going away; nothing is left to free
            self.memory = None


@dataclass(frozen=True)
class _Parameter:
    """One parameter of a kernel, read from its source: `scalar` is the numpy dtype of one lane."""

    name: str
    space: str  # "global", "constant", "local" or "" for a value
    scalar: np.dtype
    lanes: int


_SCALARS = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "long": "i8", "ulong": "u8", "float": "f4", "double": "f8", "half": "f2",
}  # fmt: skip
_KERNEL = re.compile(
    r"__kernel\s+(?:__attribute__\s*\(\(.*?\)\)\s*)*void\s+(\w+)\s*\(([^)]*)\)", re.S
)
_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.S)
_TYPE = re.compile(r"\b(" + "|".join(_SCALARS) + r")(2|3|4|8|16)?\b")


def kernel_parameters(source: str) -> dict[str, tuple[_Parameter, ...]]:
    """Every kernel of an OpenCL C source with its parameters, in order."""
    found = {}
    for name, inside in _KERNEL.findall(_COMMENT.sub(" ", source)):
        parameters = []
        for text in filter(None, (part.strip() for part in inside.split(","))):
            kind = _TYPE.search(text)
            words = re.findall(r"\w+", text)
            if kind is None:
                raise ValueError(f"{name}: expected a built-in scalar or vector type, got {text!r}")
            space = next((s for s in ("global", "constant", "local") if f"__{s}" in words), "")
            lanes = int(kind[2] or 1)
            parameters.append(_Parameter(words[-1], space, np.dtype(_SCALARS[kind[1]]), lanes))
        found[name] = tuple(parameters)
    return found


class Launch:
    """One kernel with its arguments set, ready to be enqueued any number of times."""

    def __init__(
        self,
        device: Device,
        kernel: Any,
        parameters: tuple[_Parameter, ...],
        stage: str,
        items: int | tuple[int, int],
        local: tuple[int, ...],
        arguments: Mapping[str, Any],
    ) -> None:
        self.stage = stage
        self._device = device
        self._kernel = kernel
        self._position = {p.name: (i, p) for i, p in enumerate(parameters)}
        self._held: dict[str, Any] = {}  # buffers stay alive as long as the launch
        self._local = local
        self.items = items
        missing = sorted(set(self._position) - set(arguments))
        if missing:
            raise TypeError(
                f"{kernel.function_name}: expected arguments {missing}, got none of them"
            )
        self.set(**arguments)

    @property
    def items(self) -> tuple[int, ...]:
        """Work-items asked for; the launch is padded to whole work-groups."""
        return self._items

    @items.setter
    def items(self, items: int | tuple[int, ...]) -> None:
        self._items = (items,) if isinstance(items, int | np.integer) else tuple(items)
        self._global = tuple(
            max(-(-int(n) // size), 1) * size
            for n, size in zip(self._items, self._local, strict=True)
        )

    def set(self, **arguments: Any) -> None:
        """Set arguments by name: a `Buffer` for a pointer, a number or a short tuple for a value."""
        for name, value in arguments.items():
            if name not in self._position:
                expected = ", ".join(self._position)
                raise TypeError(
                    f"{self._kernel.function_name}: expected one of {expected}, got {name}"
                )
            index, parameter = self._position[name]
            self._kernel.set_arg(index, self._argument(parameter, value))
            self._held[name] = value

    def _argument(self, parameter: _Parameter, value: Any) -> Any:
        where = f"{self._kernel.function_name}: {parameter.name}"
        if parameter.space == "local":
            return self._device._cl.LocalMemory(int(value))
        if parameter.space:
            if not isinstance(value, Buffer):
                raise TypeError(f"{where}: expected a Buffer, got {type(value).__name__}")
            if value.dtype.itemsize != parameter.scalar.itemsize or (
                (value.dtype.kind == "f") != (parameter.scalar.kind == "f")
            ):
                raise TypeError(
                    f"{where}: expected {parameter.scalar}, got {value.name} of {value.dtype}"
                )
            return value.memory
        if parameter.lanes == 1:
            info = np.iinfo(parameter.scalar) if parameter.scalar.kind in "iu" else None
            if info is not None and not info.min <= int(value) <= info.max:
                raise ValueError(f"{where}: expected {info.min} to {info.max}, got {value}")
            return parameter.scalar.type(value)
        lanes = 4 if parameter.lanes == 3 else parameter.lanes
        vector = np.zeros(lanes, parameter.scalar)
        vector[: parameter.lanes] = value
        return vector

    def __call__(self, timeline: Timeline) -> Any:
        """Enqueue; never waits. Returns the event, which `timeline` also keeps under the launch's stage."""
        cl = self._device._cl
        event = cl.enqueue_nd_range_kernel(
            self._device.queue, self._kernel, self._global, self._local
        )
        timeline.add(self.stage, event)
        return event


class Program:
    """A built program: its kernels become launches."""

    def __init__(self, device: Device, program: Any, source: str) -> None:
        self._device = device
        self._program = program
        self.kernels = kernel_parameters(source)

    def launch(
        self,
        kernel: str,
        items: int | tuple[int, int],
        *,
        stage: str,
        local: int | tuple[int, ...] | None = None,
        **arguments: Any,
    ) -> Launch:
        """A kernel bound to its arguments, given by the names that its source gives them.

        Args:
            kernel: the kernel's name.
            items: work-items, 1-D or 2-D; padded to whole work-groups, so the kernel checks its bounds.
            stage: the stage that its seconds count towards.
            local: work-group size; None takes the device's fixed one. Kernels with barriers give theirs.
            **arguments: a `Buffer` per pointer, bytes per `__local` pointer, a number or tuple per value.

        Raises:
            TypeError: an argument missing, unknown or of another dtype than the kernel's parameter.
            ValueError: a value out of its integer type's range.
        """
        if kernel not in self.kernels:
            raise ValueError(f"kernel: expected one of {', '.join(self.kernels)}, got {kernel}")
        dimensions = 1 if isinstance(items, int | np.integer) else len(items)
        if local is None:
            local = (self._device.local_size,) + (1,) * (dimensions - 1)
        sizes = (local,) if isinstance(local, int) else tuple(local)
        made = self._device._cl.Kernel(self._program, kernel)
        return Launch(self._device, made, self.kernels[kernel], stage, items, sizes, arguments)


class Device:
    """One OpenCL device with its queue, its pool of memory and the programs built for it."""

    def __init__(
        self,
        device: Any,
        *,
        memory_limit: int | None = None,
        local_size: int | None = None,
        one_core: bool = False,
    ) -> None:
        cl = self._cl = _opencl()
        self._device = device
        self.context = cl.Context([device])
        properties = cl.command_queue_properties.PROFILING_ENABLE
        self.queue = cl.CommandQueue(self.context, device, properties=properties)
        self._pool = cl.tools.MemoryPool(cl.tools.ImmediateAllocator(self.queue))
        self.memory_limit = int(memory_limit or device.global_mem_size)
        self._largest = int(device.max_mem_alloc_size)
        self._used = 0
        self.local_size = min(local_size or LOCAL_SIZE, device.max_work_group_size)
        self._programs: dict[tuple[Any, ...], Program] = {}
        self.is_cpu = bool(device.type & cl.device_type.CPU)
        ratio = self._builtins_ratio()
        self.facts = DeviceFacts(
            name=device.name.strip(),
            platform=device.platform.name.strip(),
            driver=f"{device.platform.version.strip()}; driver {device.driver_version.strip()}",
            version=device.version.strip(),
            kind="cpu" if self.is_cpu else "gpu" if device.type & cl.device_type.GPU else "other",
            compute_units=int(device.max_compute_units),
            memory_bytes=int(device.global_mem_size),
            largest_allocation_bytes=self._largest,
            local_bytes=int(device.local_mem_size),
            extensions=tuple(sorted(device.extensions.split())),
            one_core=one_core,
            builtins_ratio=ratio,
            prelude=ratio > 2.5,
        )

    @classmethod
    def open(
        cls,
        name: str | None = None,
        *,
        memory_limit: int | None = None,
        local_size: int | None = None,
        one_core: bool = False,
    ) -> Device:
        """The device asked for, ready to use.

        Args:
            name: part of a platform's or device's name ("pocl", "nvidia"), or "platform:device" by index ("0:1");
                None takes `LODBENCH_DEVICE`, else PoCL, else the first device found.
            memory_limit: bytes that may be allocated, to make running out testable; None takes the device's own.
            local_size: work-items per group where a kernel does not fix it; None takes 64.
            one_core: use a single compute unit of the device.

        Raises:
            DeviceError: no driver, no such device, or the device cannot be split.
        """
        found = list_devices()
        wanted = name or os.environ.get("LODBENCH_DEVICE") or ""
        labels = "; ".join(f"{index} {platform}: {device}" for index, platform, device, _ in found)
        if not found:
            raise DeviceError("device: expected an OpenCL driver, got none; run `lodbench doctor`")
        if wanted:
            text = wanted.lower()
            matches = [
                handle
                for index, platform, device, handle in found
                if text == index
                or (not re.fullmatch(r"\d+:\d+", text) and text in f"{platform} {device}".lower())
                or (text == "pocl" and "portable computing" in platform.lower())
            ]
            if not matches:
                raise DeviceError(f"device: expected one of [{labels}], got {wanted!r}")
        else:
            pocl = [
                handle
                for _, platform, _, handle in found
                if "portable computing" in platform.lower()
            ]
            matches = pocl or [handle for *_, handle in found]
        handle = matches[0]
        if one_core:
            cl = _opencl()
            try:
                handle = handle.create_sub_devices([cl.device_partition_property.EQUALLY, 1])[0]
            except cl.Error as error:
                if handle.max_compute_units > 1:
                    raise Unsupported(
                        f"needs a device that can be split, device has none: {error}"
                    ) from None
        return cls(handle, memory_limit=memory_limit, local_size=local_size, one_core=one_core)

    @property
    def slug(self) -> str:
        """The device's name for a folder, such as `pocl-amd-epyc`."""
        platform = (
            "pocl" if "portable" in self.facts.platform.lower() else self.facts.platform.split()[0]
        )
        name = re.sub(r"^(pthread|cpu|basic)-", "", self.facts.name.split("(")[0].strip())
        words = re.sub(r"[^a-z0-9]+", "-", f"{platform} {name}".lower()).strip("-")
        return words + ("-one-core" if self.facts.one_core else "")

    def _builtins_ratio(self) -> float:
        """How many times slower the driver's `mad` is than `a * b + c`; kept on disk per driver.

        Some PoCL builds do not inline their own library on some hosts; every built-in is then a call, and
        the prelude shadows them.
        """
        forced = os.environ.get("LODBENCH_PRELUDE")
        if forced in ("0", "1"):
            return float("inf") if forced == "1" else 1.0
        if not self.is_cpu:
            return 1.0
        device = self._device
        key = f"{device.platform.version}|{device.version}|{device.name}|{device.driver_version}"
        path = (
            cache_folder() / "builtins" / (hashlib.sha256(key.encode()).hexdigest()[:16] + ".json")
        )
        try:
            return float(json.loads(path.read_text())["ratio"])
        except (OSError, ValueError, KeyError, TypeError):
            pass
        program = self._compile(
            [(str(KERNELS / "common/probe.cl"), (KERNELS / "common/probe.cl").read_text())], ""
        )
        count = 1 << 16
        memory = self._cl.Buffer(self.context, self._cl.mem_flags.READ_WRITE, 4 * count)
        best = {}
        for name in (
            "probe_builtin",
            "probe_operator",
        ) * 8:  # the first turn compiles, the minimum drops it
            kernel = self._cl.Kernel(program, name)
            kernel.set_args(memory, np.uint32(count))
            event = self._cl.enqueue_nd_range_kernel(self.queue, kernel, (count,), (LOCAL_SIZE,))
            event.wait()
            seconds = (event.profile.end - event.profile.start) * 1e-9
            best[name] = min(best.get(name, np.inf), seconds)
        ratio = round(best["probe_builtin"] / max(best["probe_operator"], 1e-9), 2)
        write_cache(path, json.dumps({"ratio": ratio, "device": key}))
        return ratio

    def _compile(self, texts: Iterable[tuple[str, str]], options: str) -> Any:
        joined = "".join(f'#line 1 "{name}"\n{text}\n' for name, text in texts)
        cl = self._cl
        try:
            return cl.Program(self.context, joined).build(options=options.split())
        except cl.Error as error:
            log = [line for line in str(error).splitlines() if "error" in line.lower()]
            files = ", ".join(name for name, _ in texts)
            raise DeviceError(
                f"build of {files} failed on {self._device.name.strip()} with options {options!r}:\n"
                + ("\n".join(log) or str(error))
            ) from None

    def build(
        self, *files: str | Path, defines: Mapping[str, int | float] | None = None
    ) -> Program:
        """The program of these kernel files, relative to `kernels/`, built once per set of defines.

        Files named on a `// Needs` line are joined in front; `common/prelude.cl` comes first where the driver needs it.

        Raises:
            DeviceError: the build failed; file, line and options are in the text.
        """
        options = " ".join(
            f"-D {name}={value}" + ("f" if isinstance(value, float) else "")
            for name, value in (defines or {}).items()
        )
        key = (files, options)
        if key not in self._programs:
            texts: dict[str, str] = {}
            if self.facts.prelude:
                self._join(PRELUDE, texts)
            for file in files:
                self._join(str(file), texts)
            source = "\n".join(text for name, text in texts.items() if name != PRELUDE)
            self._programs[key] = Program(
                self, self._compile(list(texts.items()), f"-w {options}"), source
            )
        return self._programs[key]

    def _join(self, file: str, texts: dict[str, str]) -> None:
        if file in texts:
            return
        text = (KERNELS / file).read_text()
        for line in re.findall(r"^// Needs +(.*)$", text, re.M):
            for needed in re.split(r"[,\s]+", line.strip()):
                self._join(needed, texts)
        texts[file] = text

    def allocate(self, name: str, shape: int | tuple[int, ...], dtype: Any) -> Buffer:
        """Uninitialised memory for an array of `shape` and `dtype`.

        Raises:
            Unsupported: the device, or its limit, has no room for it.
        """
        shape = (shape,) if isinstance(shape, int | np.integer) else tuple(int(n) for n in shape)
        dtype = np.dtype(dtype)
        size = max(int(np.prod(shape, dtype=np.int64)) * dtype.itemsize, 1)
        free = self.memory_limit - self._used
        if size > free or size > self._largest:
            limit = "free" if size > free else "the largest allocation"
            raise Unsupported(
                f"{name}: needs {size:,} bytes of device memory, device has {min(free, self._largest):,} ({limit})"
            )
        try:
            memory = self._pool.allocate(size)
        except self._cl.Error as error:
            raise Unsupported(
                f"{name}: needs {size:,} bytes of device memory, device refused: {error}"
            ) from None
        self._used += size
        return Buffer(name, shape, dtype, memory, self._given_back)

    def _given_back(self, size: int) -> None:
        self._used -= size

    @property
    def used_bytes(self) -> int:
        """Bytes of all living buffers."""
        return self._used

    def upload(
        self,
        name: str,
        values: ArrayLike,
        dtype: Any = None,
        shape: tuple[int | None, ...] | None = None,
    ) -> Buffer:
        """A buffer holding `values`, which must already have the dtype and shape (None: any length) asked for.

        Raises:
            TypeError: another dtype. Nothing is converted here: float64 read as float32 would be garbage.
            ValueError: another shape.
            Unsupported: no room.
        """
        array = np.ascontiguousarray(values)
        if dtype is not None and array.dtype != np.dtype(dtype):
            raise TypeError(f"{name}: expected {np.dtype(dtype)}, got {array.dtype}")
        if shape is not None and (
            array.ndim != len(shape)
            or any(
                want is not None and want != have
                for want, have in zip(shape, array.shape, strict=True)
            )
        ):
            wanted = tuple("n" if want is None else want for want in shape)
            raise ValueError(f"{name}: expected shape {wanted}, got {array.shape}")
        buffer = self.allocate(name, array.shape, array.dtype)
        if array.size:
            self._cl.enqueue_copy(self.queue, buffer.memory, array, is_blocking=True)
        return buffer

    def read(self, buffer: Buffer, rows: int | None = None) -> NDArray[Any]:
        """The buffer's content, or its first `rows` rows, once all that was enqueued is done."""
        shape = buffer.shape if rows is None else (rows, *buffer.shape[1:])
        result = np.empty(shape, buffer.dtype)
        if result.size:
            self._cl.enqueue_copy(self.queue, result, buffer.memory, is_blocking=True)
        else:
            self.wait()
        return result

    def fill(
        self,
        timeline: Timeline,
        stage: str,
        buffer: Buffer,
        value: Any,
        size_bytes: int | None = None,
    ) -> None:
        """Enqueue the driver's own fill of the whole buffer, or its first `size_bytes`, with one value."""
        pattern = buffer.dtype.type(value)
        size = buffer.size_bytes if size_bytes is None else size_bytes
        timeline.add(
            stage, self._cl.enqueue_fill_buffer(self.queue, buffer.memory, pattern, 0, size)
        )

    def wait(self) -> None:
        """Wait for everything enqueued.

        Raises:
            DeviceError: a command failed.
        """
        try:
            self.queue.finish()
        except self._cl.Error as error:
            raise DeviceError(f"a command failed on {self.facts.name}: {error}") from None


def list_devices() -> list[tuple[str, str, str, Any]]:
    """("platform:device" index, platform name, device name, handle) of every device, in the loader's order."""
    cl = _opencl()
    try:
        platforms = cl.get_platforms()
    except cl.Error:
        return []
    found = []
    for p, platform in enumerate(platforms):
        try:
            devices = platform.get_devices()
        except cl.Error:
            continue
        for d, device in enumerate(devices):
            found.append((f"{p}:{d}", platform.name.strip(), device.name.strip(), device))
    return found
