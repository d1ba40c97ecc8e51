"""A page of HTML with the tables and the pictures of a measurement, in a single file, which needs no network."""

import csv
from base64 import b64encode
from collections.abc import Iterable, Sequence
from io import StringIO
from pathlib import Path

from povgen.files import save
from povgen.scene.sdl import to_report

LONGEST = 300  # rows of a table on the page

Table = tuple[str, Sequence[str], Sequence[Sequence[str]]]  # name, head, rows


def save_report(path: Path, title: str, text: str, tables: Sequence[Table], pictures: Iterable[Path]) -> None:
    """Write the page. A row whose last column says FAILS is red. The pictures are PNG files."""
    encoded = [(picture.stem, b64encode(picture.read_bytes()).decode()) for picture in pictures]
    save(to_report(title, text, tables, encoded).encode(), path)


def read_tables(folder: Path) -> list[Table]:
    """Return the tables of a folder's .csv files, but those that are too long for the page."""
    found: list[Table] = []
    for file in sorted(folder.glob("*.csv")):
        head, *rows = csv.reader(StringIO(file.read_text("utf-8")))
        if len(rows) <= LONGEST:
            found.append((file.name, head, rows))
    return found
