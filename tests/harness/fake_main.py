"""`lodbench` with the fake subjects, for tests that need a process of its own: SECONDS ARGUMENTS..."""

import sys

from lodbench.harness.__main__ import main
from lodbench.harness.cli import interrupt

interrupt.install()  # before the rest is imported, as `lodbench` does
from tests.harness.fake import install  # noqa: E402

install(seconds=float(sys.argv.pop(1)))
sys.exit(main())
