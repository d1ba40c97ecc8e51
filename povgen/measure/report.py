"""A page of HTML with the tables and the pictures of a measurement, in a single file, which needs no network."""

import csv
from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
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


def times(folder: Path) -> dict[Path, int]:
    """Return when each file of a folder was written, nanoseconds."""
    return {path: path.stat().st_mtime_ns for path in folder.iterdir() if path.is_file()}


def written(folder: Path, before: Mapping[Path, int], suffix: str) -> list[Path]:
    """Return the files with a suffix that were written to a folder since `times` returned `before`, sorted by path."""
    return sorted(path for path, time in times(folder).items() if path.suffix == suffix and before.get(path) != time)


def read_tables(files: Iterable[Path]) -> list[Table]:
    """Return the tables of .csv files, except those with more than LONGEST rows."""
    found: list[Table] = []
    for file in files:
        head, *rows = csv.reader(StringIO(file.read_text("utf-8")))
        if len(rows) <= LONGEST:
            found.append((file.name, head, rows))
    return found
