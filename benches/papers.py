"""The experiments of the four papers, with the installed footnav.

``python benches/papers.py --help``.
"""

import sys

from papers.command import main

if __name__ == "__main__":
    sys.exit(main())
