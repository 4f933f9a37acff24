"""Device functions called over arrays: one kernel of one statement, made for the call."""

import numpy as np

from lodbench.kernels.opencl.timeline import Timeline

KERNEL = """// Needs {needs}
{before}
__kernel void {name}({parameters}, const uint count)
{{
    const uint i = get_global_id(0);
    if (i >= count) return;
    {body}
}}
"""
_TYPES = {
    "int8": "char", "uint8": "uchar", "int32": "int", "uint32": "uint", "int64": "long",
    "float32": "float",
}  # fmt: skip


class Caller:
    """Runs statements that use the functions of `needs` on a device; `folder` is for the kernels' files."""

    def __init__(self, device, folder, needs, before="", **defines):
        self.device, self.folder, self.needs = device, folder, needs
        self.before, self.defines = before, defines
        self._names = {}

    def __call__(self, body, count, outputs, **inputs):
        """Run `body` for i = 0 .. count - 1 and give what it wrote.

        Args:
            body: OpenCL C; it sees `i`, every input and every output by its name, as arrays.
            count: work-items.
            outputs: name -> the array that it begins as, which is not changed, or (length, dtype) of zeros.
            **inputs: arrays, or whole numbers.

        Returns:
            name -> array, of the outputs.
        """
        outputs = {
            name: np.zeros(*value) if isinstance(value, tuple) else np.array(value)
            for name, value in outputs.items()
        }
        parameters = [
            f"const int {name}"
            if isinstance(value, int)
            else f"__global {'' if name in outputs else 'const '}{_TYPES[value.dtype.name]} *{name}"
            for name, value in {**inputs, **outputs}.items()
        ]
        name = self._kernel(body, ", ".join(parameters))
        given = {
            key: value if isinstance(value, int) else self.device.upload(key, value)
            for key, value in {**inputs, **outputs}.items()
        }
        program = self.device.build(self.folder / f"{name}.cl", defines=self.defines)
        program.launch(name, count, stage="test", count=count, **given)(Timeline())
        return {key: self.device.read(given[key]) for key in outputs}

    def _kernel(self, body, parameters):
        """The name of the kernel of this body, written and built once: a build takes longer than a test."""
        if (body, parameters) not in self._names:
            name = self._names[body, parameters] = f"called_{len(self._names)}"
            text = KERNEL.format(
                needs=self.needs, before=self.before, name=name, parameters=parameters, body=body
            )
            (self.folder / f"{name}.cl").write_text(text)
        return self._names[body, parameters]
