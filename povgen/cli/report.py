"""What the command line says beside its results: messages, warnings, progress."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from povgen.scene.models import Scene
    from povgen.settings import Rendering


def say(message: str) -> None:
    """Print on standard error. A message that cannot be written there stops nothing."""
    try:
        print(message, file=sys.stderr, flush=True)
    except OSError:
        sys.stderr = open(os.devnull, "w")  # else Python tries again at its end, and exits with status 120


def one_line(message: str) -> str:
    """A message that may quote anything, in one line that a terminal shows as it is; of a long one the ends."""
    message = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in message)
    return message if len(message) <= 1000 else f"{message[:500]} ... {message[-400:]}"


def warn(scenes: list["Scene"], rendering: "Rendering | None" = None) -> None:
    """Say once, of each limit that frames cross, what it is and how many do."""
    from povgen.scene.prediction import warnings

    if rendering:
        from povgen.rendering.frames import known

        for scene in scenes:
            known(scene)
    said: dict[str, list[str]] = {}
    for scene in scenes:
        for name, text in warnings(scene, rendering):
            said.setdefault(name, []).append(text)
    for texts in said.values():
        also = f" (so in {len(texts)} of {len(scenes)} frames)" if len(scenes) > 1 else ""
        say(f"povgen: warning: {texts[0]}{also}")


@contextmanager
def progress(what: str, total: int, quiet: bool) -> Iterator[Callable[[], None]]:
    """A bar with the time left on a terminal, a line now and then elsewhere. Yields what to call after each frame."""
    if quiet:
        yield lambda: None
    elif sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        name = TextColumn("{task.description}", markup=False)
        columns = name, BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
        with Progress(*columns, console=Console(stderr=True)) as progress:
            task = progress.add_task(what, total=total)
            yield lambda: progress.advance(task)
    else:
        count = 0

        def line() -> None:
            nonlocal count
            count += 1
            if count == total or count * 10 // total > (count - 1) * 10 // total:
                say(f"{what}: {count}/{total} frames")

        yield line
