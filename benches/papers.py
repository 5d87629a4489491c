"""The experiments of the four papers, from the source tree: ``python benches/papers.py [OPTIONS]``.

The options are those of ``footnav papers``.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "python"))

from footnav.cli import main

if __name__ == "__main__":
    sys.exit(main(["papers", *sys.argv[1:]]))
