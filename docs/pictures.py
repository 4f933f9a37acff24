"""The guide's pictures, by the commands beside them: `make pictures`, or `python docs/pictures.py [PAGE ...]`.

Every `lodbench` line of `docs/systems/*.md` runs, page by page in an empty folder; what a page shows goes to
`docs/pictures/`, with 64 colours, which makes it a third of the size.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).parent
COLOURS = 64


def commands(page):
    """Command lines of a page, in their order."""
    return re.findall(r"(?m)^(lodbench .+)$", page)


def shown(page):
    """Names of the pictures that a page shows."""
    return re.findall(r"\]\(\.\./pictures/([\w-]+\.png)\)", page)


def main():
    """Make all of them, or those of the pages that are named; a command that fails stops it."""
    for path in sorted(DOCS.glob("systems/*.md")):
        if sys.argv[1:] and path.stem not in sys.argv[1:]:
            continue
        page = path.read_text("utf-8")
        with tempfile.TemporaryDirectory() as folder:
            for line in commands(page):
                words = [sys.executable, "-m", "lodbench.harness", *line.split()[1:]]
                subprocess.run(words, cwd=folder, check=True, stdout=subprocess.DEVNULL)
            for name in shown(page):
                small = Image.open(Path(folder) / name).convert("RGB").quantize(COLOURS)
                small.save(DOCS / "pictures" / name, optimize=True)
                sys.stdout.write(f"{name}: {(DOCS / 'pictures' / name).stat().st_size} bytes\n")


if __name__ == "__main__":
    main()
