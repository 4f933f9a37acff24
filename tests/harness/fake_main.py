"""`lodbench` with the fake subjects, for tests that need a process of its own: SECONDS ARGUMENTS..."""

import sys

from lodbench.harness.cli.app import main
from tests.harness.fake import install

install(seconds=float(sys.argv[1]))
sys.exit(main(sys.argv[2:]))
