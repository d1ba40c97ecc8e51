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


def wrote(path: Path) -> None:
    """Print that a file was written, in one line: its name can have line breaks. Raises OSError."""
    tell(f"wrote {one_line(str(path))}")


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
    elif _in_notebook():
        # rich would need ipywidgets
        shown = import_module("IPython.display").ProgressBar(total)
        shown.display()

        def advance() -> None:
            shown.progress += 1

        yield advance
    elif sys.stderr is not None and sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        name = TextColumn("{task.description}", markup=False)
        columns = name, BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
        with Progress(*columns, console=Console(stderr=True)) as progress:
            task = progress.add_task(one_line(what), total=total)
            yield lambda: progress.advance(task)
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
    if quiet or sys.stderr is None or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = TextColumn("{task.description}", markup=False), BarColumn(), TaskProgressColumn(), TimeRemainingColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(one_line(what), total=total)
        yield lambda part: progress.advance(task, part)


def _in_notebook() -> bool:
    """Whether this process is a Jupyter kernel."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    return hasattr(shell, "kernel")
