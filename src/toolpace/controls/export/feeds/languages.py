"""The words of each language in which a program may be."""

from __future__ import annotations

from toolpace.controls.export.feeds.cldata import Cldata
from toolpace.controls.export.feeds.klartext import Klartext
from toolpace.controls.export.feeds.sinumerik import Sinumerik
from toolpace.controls.export.feeds.word_address import WordAddress
from toolpace.controls.export.feeds.words import FeedWords

LANGUAGES: dict[str, FeedWords] = {
    "word-address": WordAddress(),
    "sinumerik": Sinumerik(),
    "heidenhain": Klartext(),
    "cldata": Cldata(),
}
"""Language of a controller, or `cldata`, to its words."""
