"""Plans side by side: by operation, by what limits, and over the path."""

from __future__ import annotations

from toolpace.results.compare.comparison import Compared, compared

__all__ = ["Compared", "compared"]
