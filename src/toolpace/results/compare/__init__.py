"""Comparison of plans: by operation, by limit, and over the path."""

from __future__ import annotations

from toolpace.results.compare.comparison import Compared, compared

__all__ = ["Compared", "compared"]
