"""The words of each language in which a program may be."""

from __future__ import annotations

from toolpace.exporting.feeds.cldata import Cldata
from toolpace.exporting.feeds.klartext import Klartext
from toolpace.exporting.feeds.sinumerik import Sinumerik
from toolpace.exporting.feeds.word_address import WordAddress
from toolpace.exporting.feeds.words import FeedWords

LANGUAGES: dict[str, FeedWords] = {
    "word-address": WordAddress(),
    "sinumerik": Sinumerik(),
    "heidenhain": Klartext(),
    "cldata": Cldata(),
}
"""Language of a controller, or `cldata`, to its words."""
