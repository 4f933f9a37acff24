"""`python -m lodbench.harness`: the command line."""

import sys

from lodbench.harness.cli import main

sys.exit(main())
