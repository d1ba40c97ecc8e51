"""The errors that are not faults of povgen, and how a message shows a value.

`validation` writes the message about a wrong value.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from errno import EMFILE


class InputError(ValueError):
    """A value that the user gave is not allowed. The message names it and says what is allowed."""


class PovrayError(RuntimeError):
    """POV-Ray is missing, failed, was killed or took too long. The message says which, and where."""

    line: int | None = None  # in the scene's text, counted from 1, if POV-Ray named one


class TransientError(PovrayError):
    """POV-Ray was killed or took too long. Another frame, or another try, may succeed."""


@contextmanager
def input_errors() -> Iterator[None]:
    """Raise InputError in place of the error that `optics` raises for a wrong value. Can also be a decorator."""
    try:
        yield
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(str(error)) from None


def shown(value: object, most: int = 60) -> str:
    """Return a value as text, as for a message: one line of at most 60 characters, or of `most`."""
    try:
        text = " ".join(line.strip() for line in repr(_plain(value)).splitlines())  # numpy's arrays have several
    except (ValueError, RecursionError):  # a number with thousands of digits, or thousands of nested tables
        return f"a very long {type(value).__name__}"
    return text if len(text) <= most else text[: most - 3] + "..."


def at_least(limit: float) -> str:
    """Return a lower limit as text with four digits, rounded up: what a message names is allowed."""
    return _limit(limit, ROUND_CEILING)


def at_most(limit: float) -> str:
    """Return an upper limit as text with four digits, rounded down: what a message names is allowed."""
    return _limit(limit, ROUND_FLOOR)


def _limit(limit: float, rounding: str) -> str:
    decimal = f"{limit:.12g}"  # without the rounding errors of binary numbers
    return f"{float(Context(prec=4, rounding=rounding).create_decimal(decimal)):.4g}"


def _plain(value: object) -> object:
    """Return Python's own numbers in place of numpy's, whose text would be np.float64(2.0)."""
    if type(value) is list:
        return [*map(_plain, value)]
    if type(value) is tuple:
        return tuple(map(_plain, value))
    item = getattr(value, "item", None)
    return item() if item and type(value).__module__ == "numpy" and getattr(value, "shape", None) == () else value


def one_line(message: str) -> str:
    """Return a message as one line of printable characters. Of a long message, return its beginning and its end."""
    message = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in message)
    return message if len(message) <= 1000 else f"{message[:500]} ... {message[-400:]}"


def message_of(error: Exception) -> str:
    """Return an error's message. For a file it is the file's name and the reason, without errno."""
    if isinstance(error, OSError) and error.strerror:
        file = error.filename2 or error.filename  # of two files, the second is written
        limit = " (ulimit -n; fewer --workers need fewer files)" if error.errno == EMFILE else ""
        return f"{file}: {error.strerror}{limit}" if file else f"{error.strerror}{limit}"
    return str(error)
