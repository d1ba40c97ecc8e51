"""What the command line prints on standard error: messages, warnings and progress."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from povgen.scene.models import Scene
    from povgen.settings import Rendering


def say(message: str) -> None:
    """Print on standard error. If that fails, the program goes on."""
    try:
        print(message, file=sys.stderr, flush=True)
    except OSError:
        # otherwise Python writes again when it ends, fails, and exits with status 120
        sys.stderr = open(os.devnull, "w")


def one_line(message: str) -> str:
    """Return a message as one line of printable characters. Of a long message, return its beginning and its end."""
    message = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in message)
    return message if len(message) <= 1000 else f"{message[:500]} ... {message[-400:]}"


def warn(scenes: list["Scene"], rendering: "Rendering | None" = None) -> None:
    """Print one warning for each limit that scenes exceed, with the number of these scenes."""
    from povgen.scene.prediction import warnings

    if rendering:
        from povgen.rendering import surveys

        for scene in scenes:
            surveys.load(scene)
    texts_by_limit: dict[str, list[str]] = {}
    for scene in scenes:
        for limit, text in warnings(scene, rendering):
            texts_by_limit.setdefault(limit, []).append(text)
    for texts in texts_by_limit.values():
        also = f" (so in {len(texts)} of {len(scenes)} frames)" if len(scenes) > 1 else ""
        say(f"povgen: warning: {texts[0]}{also}")


@contextmanager
def progress(what: str, total: int, quiet: bool) -> Iterator[Callable[[], None]]:
    """Show a progress bar on a terminal, up to ten lines elsewhere. Yield the function to call after each frame."""
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

        def say_each_tenth() -> None:
            nonlocal count
            count += 1
            if count == total or count * 10 // total > (count - 1) * 10 // total:
                say(f"{what}: {count}/{total} frames")

        yield say_each_tenth
