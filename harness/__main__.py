"""`lodbench` and `python -m lodbench.harness`: Ctrl-C is seen to before anything else is imported."""

import sys

from lodbench.harness.cli import interrupt


def main() -> int:
    """The command line from start to end; returns the exit code."""
    interrupt.install()
    from lodbench.harness.cli import app as cli

    interrupt.running(True)
    try:
        code = cli.main()
    except KeyboardInterrupt:  # between two lines of the command line itself
        code = cli.interrupted()
    interrupt.running(False)
    return cli.interrupted() if interrupt.pending() else code


if __name__ == "__main__":
    sys.exit(main())
