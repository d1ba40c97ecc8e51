"""The teaching page's sentences: povgen/liveview/languages/ has a table for each language."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from povgen.inputs.pieces import PIECES
from povgen.sheets.sheet import Sheet

FOLDER = Path(__file__).with_name("languages")


def tables(kinds: Mapping[str, type[Sheet]]) -> dict[str, dict[str, Any]]:
    """Return the tables by the names of the languages, English first, with texts for all these kinds of sheets.

    A kind that a table does not know has the texts of its class, which are English. Pieces have their own file.
    """
    found = {path.stem: tomllib.loads(path.read_text("utf-8")) for path in sorted(FOLDER.glob("*.toml"))}
    for language, table in found.items():
        table["things"] |= {piece: names[language] for piece, names in PIECES.items() if language in names}
        other = table["kinds"].pop("other")
        for name, kind in kinds.items():
            own = {part: text.format(title=kind.title, does=kind.does) for part, text in other.items()}
            texts = table["kinds"].setdefault(name, own)
            labels = {"alpha": table["controls"]["alpha"]} | texts.get("labels", {})
            texts["labels"] = {each.name: labels.get(each.name, each.about) for each in kind.parameters}
    return {"en": found.pop("en"), **found}
