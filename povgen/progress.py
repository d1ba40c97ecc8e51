"""Messages and progress bars on standard error and in notebooks."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path

from povgen.errors import one_line


def tell(message: str) -> None:
    """Print on standard output, as `say` does on standard error. Raises OSError."""
    print(_printable(message))


def wrote(path: Path, files: int = 0) -> None:
    """Print that a file was written, or numbered files, in one line: names can have line breaks. Raises OSError."""
    tell(f"wrote {one_line(str(path))}" + (f": {counted(files, 'file')}" if files else ""))


def say(message: str) -> None:
    """Print on standard error. If that fails, the program goes on.

    Characters that a terminal would obey, as a file's name can have them, are printed as their codes.
    """
    try:
        print(_printable(message), file=sys.stderr, flush=True)
    except OSError:
        # otherwise Python writes again when it ends, fails, and exits with status 120
        sys.stderr = open(os.devnull, "w")


def counted(number: int, what: str) -> str:
    """Return a number of things as text: 1 frame, 2 frames."""
    return f"{number} {what}{'s' * (number != 1)}"


def _printable(message: str) -> str:
    return "\n".join(map(one_line, message.split("\n")))


@contextmanager
def bar(what: str, total: int, quiet: bool = False, unit: str = "frames") -> Iterator[Callable[[], None]]:
    """Show a progress bar in a notebook or on a terminal, up to ten lines elsewhere.

    Yield the function to call after each frame, or other unit.
    """
    if quiet:
        yield lambda: None
    elif hasattr(sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None, "kernel"):
        # in a Jupyter kernel, where rich would need ipywidgets
        shown = import_module("IPython.display").ProgressBar(total)
        shown.display()

        def advance() -> None:
            shown.progress += 1

        yield advance
    elif _is_terminal():
        with _on_terminal(what, total, parts=False) as advance_by:
            yield lambda: advance_by(1)
    else:
        count = 0

        def say_each_tenth() -> None:
            nonlocal count
            count += 1
            if count == total or count * 10 // total > (count - 1) * 10 // total:
                say(f"{what}: {count}/{total} {unit}")

        yield say_each_tenth


@contextmanager
def parts(what: str, total: int, quiet: bool = False) -> Iterator[Callable[[float], None] | None]:
    """Show on a terminal how much of some pictures is there, and the time left.

    Yield a function, to call with the fraction of a picture that was rendered since its last call. Yield None if
    nothing is shown. `total` is the number of pictures.
    """
    if quiet or not _is_terminal():
        yield None
        return
    with _on_terminal(what, total, parts=True) as advance_by:
        yield advance_by


@contextmanager
def _on_terminal(what: str, total: int, parts: bool) -> Iterator[Callable[[float], None]]:
    """Show a progress bar on a terminal, with the number of units, or the percentage if it counts parts of them."""
    from rich import console, progress

    name, left = progress.TextColumn("{task.description}", markup=False), progress.TimeRemainingColumn()
    done = progress.TaskProgressColumn() if parts else progress.MofNCompleteColumn()
    columns = name, progress.BarColumn(), done, left
    with progress.Progress(*columns, console=console.Console(stderr=True), transient=parts) as bars:
        task = bars.add_task(one_line(what), total=total)
        yield lambda part: bars.advance(task, part)


def _is_terminal() -> bool:
    return sys.stderr is not None and sys.stderr.isatty()
