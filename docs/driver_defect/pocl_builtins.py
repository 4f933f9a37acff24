"""OpenCL built-ins of a PoCL build as calls: the same sums written with and without them, timed in turns.

Needs pyopencl and NumPy alone: pip install "pyopencl[pocl]" numpy; python pocl_builtins.py
"""

import sys

import numpy as np
import pyopencl as cl

ITEMS = 1 << 18
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
    for (int k = 0; k < 64; ++k) x = {term};
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


def main():
    """A line per built-in: milliseconds of either form, their ratio, and the largest difference of the results."""
    context = cl.create_some_context(interactive=False)
    queue = cl.CommandQueue(context, properties=cl.command_queue_properties.PROFILING_ENABLE)
    device = queue.device
    named = _name(device)
    out = sys.stdout.write
    out(f"device   {device.name}\nplatform {device.platform.version}\n")
    out(f"version  {device.version}{named and f', told that it is a {named}'}\n\n")
    out(f"{'built-in':10}{'built-in, ms':>14}{'plain, ms':>12}{'ratio':>8}{'difference':>13}\n")
    host = np.random.default_rng(0).random(ITEMS, np.float32)
    given = cl.Buffer(context, cl.mem_flags.COPY_HOST_PTR, hostbuf=host)
    values = cl.Buffer(context, cl.mem_flags.READ_WRITE, host.nbytes)
    for name, terms in FORMS.items():
        kernels = [cl.Program(context, SOURCE.format(term=t)).build().chain for t in terms]
        seconds, results = ([], []), []
        for turn in range(-2, TURNS):
            for form, kernel in enumerate(kernels):
                event = kernel(queue, (ITEMS,), (64,), given, values)
                event.wait()
                if turn >= 0:
                    seconds[form].append(1e-9 * (event.profile.end - event.profile.start))
                elif turn == -1:
                    results.append(np.empty_like(host))
                    cl.enqueue_copy(queue, results[-1], values)
        slow, quick = (1e3 * min(taken) for taken in seconds)
        apart = float(np.abs(results[0] - results[1]).max())
        out(f"{name:10}{slow:14.2f}{quick:12.2f}{slow / quick:8.1f}{apart:13.1e}\n")


main()
