"""The program's start. Signals are handled before any slow import."""

import _signal  # `signal` takes a while to load
import gc
import os
import sys


def main() -> None:
    """Run the command line (povgen.cli.app.main).

    After SIGHUP, SIGINT and SIGTERM no process and no unfinished file is left, and the exit status is 129, 130 and 143.
    """
    if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:  # it would print a traceback
        _signal.signal(_signal.SIGINT, _signal.SIG_DFL)  # until `stopping` is loaded, Ctrl-C ends povgen without a word
    if sys.platform == "win32":
        sys.exit(
            "povgen: platform = Windows; allowed: the Windows Subsystem for Linux: wsl --install, then as on Ubuntu"
        )
    # povgen has no large matrices: further threads of numpy would only wait, and waiting takes CPU time
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "1")  # povgen has none: a search for them reads many files
    gc.set_threshold(100_000)  # more than Python's default: loading makes many objects, and nearly all of them stay
    from povgen import stopping  # Windows cannot import it

    stopping.on_signals()
    from povgen.cli import app

    app.main()


if __name__ == "__main__":
    main()
