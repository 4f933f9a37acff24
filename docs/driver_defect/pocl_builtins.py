"""OpenCL built-ins of a PoCL build as calls: the same sums written with and without them, timed in turns.

Needs pyopencl and NumPy alone: pip install "pyopencl[pocl]" numpy; python pocl_builtins.py
With objdump (binutils) it also names the functions that the compiled kernels call.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

CACHE = tempfile.mkdtemp()
os.environ["POCL_CACHE_DIR"] = CACHE  # where PoCL leaves what it compiles; read when it is loaded

import numpy as np  # noqa: E402
import pyopencl as cl  # noqa: E402

ITEMS = 1 << 18
STEPS = 32  # each after the one before, written out, so that work-items can be vectorised
TURNS = 40  # of which the least counts
FORMS = {  # the same result, by a built-in and by the language
    "mad": ("mad(x, 0.999f, 0.001f)", "x * 0.999f + 0.001f"),
    "fma": ("fma(x, 0.999f, 0.001f)", "__builtin_fmaf(x, 0.999f, 0.001f)"),
    "clamp": ("clamp(x * 0.999f, 0.1f, 0.9f)", "within(x * 0.999f)"),
    "fabs": ("fabs(x - 0.5f)", "__builtin_fabsf(x - 0.5f)"),
    "sqrt": ("sqrt(x + 0.001f)", "__builtin_sqrtf(x + 0.001f)"),
    "dot": ("dot((float4)(x, 0.1f, x, 0.1f), (float4)(0.4f))", "(x + 0.1f + x + 0.1f) * 0.4f"),
}
SOURCE = """
float within(float x) {{ return x < 0.1f ? 0.1f : x > 0.9f ? 0.9f : x; }}
__kernel void chain(__global const float *restrict given, __global float *restrict values)
{{
    const uint i = get_global_id(0);
    float x = given[i];
    {steps}
    values[i] = x;
}}
"""


def _name(device):
    """Where PoCL's compiler is older than the processor and builds nothing, lodbench, if here, gives it a name."""
    try:
        from lodbench.kernels.opencl.processor import name_unknown
    except ImportError:
        return ""
    return name_unknown(device)


def _compiled():
    """Every library that PoCL has compiled so far."""
    found = set()
    for folder, _, names in os.walk(CACHE):
        found |= {os.path.join(folder, name) for name in names if name.endswith(".so")}
    return found


def _code(libraries):
    """The functions that these call and the widest registers that they use; "?" without objdump."""
    if not shutil.which("objdump"):
        return "?"
    texts = [
        subprocess.run(["objdump", "-d", path], capture_output=True, text=True).stdout
        for path in libraries
    ]
    calls = set(re.findall(r"\bcallq?\s.*<([^>+]+)", "".join(texts)))
    widths = [name for name in ("zmm", "ymm", "xmm") if f"%{name}" in "".join(texts)]
    return " ".join([*(f"calls {name}," for name in sorted(calls)), *widths[:1]])


def main():
    """A line per built-in: milliseconds of either form, their ratio, difference of the results, and their code."""
    context = cl.create_some_context(interactive=False)
    queue = cl.CommandQueue(context)
    device = queue.device
    named = _name(device)
    out = sys.stdout.write
    out(f"device   {device.name}\nplatform {device.platform.version}\n")
    out(f"version  {device.version}{named and f', told that it is a {named}'}\n\n")
    out(
        f"{'':10}{'built-in':>10}{'plain':>10}{'ratio':>8}{'apart':>10}  code of the built-in; of the plain form\n"
    )
    host = np.random.default_rng(0).random(ITEMS, np.float32)
    given = cl.Buffer(context, cl.mem_flags.COPY_HOST_PTR, hostbuf=host)
    values = cl.Buffer(context, cl.mem_flags.READ_WRITE, host.nbytes)
    for name, terms in FORMS.items():
        texts = [SOURCE.format(steps=f"x = {term}; " * STEPS) for term in terms]
        kernels = [cl.Program(context, text).build().chain for text in texts]
        seconds, results, code = ([], []), [], []
        for turn in range(-2, TURNS):
            for form, kernel in enumerate(kernels):
                known = _compiled() if turn == -2 else set()
                before = time.process_time()  # of all threads: what other processes disturb least
                kernel(queue, (ITEMS,), (64,), given, values).wait()
                if turn >= 0:
                    seconds[form].append(time.process_time() - before)
                elif turn == -1:
                    results.append(np.empty_like(host))
                    cl.enqueue_copy(queue, results[-1], values)
                else:
                    code.append(_code(_compiled() - known))
        slow, quick = (1e3 * min(taken) for taken in seconds)
        apart = float(np.abs(results[0] - results[1]).max())
        out(
            f"{name:10}{slow:10.2f}{quick:10.2f}{slow / quick:8.1f}{apart:10.1e}  {'; '.join(code)}\n"
        )
    shutil.rmtree(CACHE)


main()
