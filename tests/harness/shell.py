"""A line of a shell run in this process: pipes, and files in and out."""

import io
import shlex
import sys
from pathlib import Path
from types import SimpleNamespace

from lodbench.harness.cli import app as cli


class Bytes(io.TextIOWrapper):
    """A standard stream that is no terminal."""

    def __init__(self, data=b""):
        super().__init__(io.BytesIO(data), encoding="utf-8")


def run(line, monkeypatch):
    """What a shell does with `a | b < file > file`; the exit code and output of the last."""
    data = b""
    for stage in line.split("|"):
        words = shlex.split(stage)
        out = Path(words.pop(words.index(">") + 1)) if ">" in words else None
        if "<" in words:
            data = Path(words.pop(words.index("<") + 1)).read_bytes()
        name, *words = [word for word in words if word not in "<>"]
        assert name == "lodbench"
        monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(data), isatty=bool))
        monkeypatch.setattr(sys, "stdout", stdout := Bytes())
        code = cli.main(words)
        stdout.flush()
        data = stdout.buffer.getvalue()
        if out:
            out.write_bytes(data)
    return code, data
