"""`python -m toolpace` is the command `toolpace`."""

from __future__ import annotations

import sys

from toolpace.cli import main

if __name__ == "__main__":
    sys.exit(main())
