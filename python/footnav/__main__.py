"""``python -m footnav``: the command line."""

import sys

from footnav.cli import main

if __name__ == "__main__":
    sys.exit(main())
