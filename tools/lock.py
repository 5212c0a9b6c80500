"""Write requirements.lock: the versions of all that is installed here, apart from toolpace and what makes environments.

    python tools/lock.py

Without checksums: a wheel has another one on every platform, and only those of this one are known here.
"""

from __future__ import annotations

import re
from importlib.metadata import distributions
from pathlib import Path

LOCK = Path(__file__).parents[1] / "requirements.lock"
LEFT_OUT = {"pip", "setuptools", "wheel", "toolpace"}
HEAD = "# Versions that are tested together (make lock): constraints for `make` and for CI, not what toolpace needs.\n"


def main() -> None:
    """One line a distribution, in the order of their names."""
    found = {re.sub(r"[-_.]+", "-", each.metadata["Name"]).lower(): each.version for each in distributions()}
    lines = [f"{name}=={version}" for name, version in sorted(found.items()) if name not in LEFT_OUT]
    LOCK.write_text(HEAD + "\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
