"""The program's first lines: signals are caught before anything is loaded that is slow to load."""

from povgen import stopping


def main() -> None:
    """Run the command line, as povgen.cli.app.main.

    Exit status 129, 130 and 143 after SIGHUP, SIGINT and SIGTERM, which leave no process and no part of a file behind.
    """
    stopping.on_signals()
    try:
        from povgen.cli import app

        app.main()
    except BaseException:  # whatever became of the handler's exception on its way here
        if not stopping.asked():
            stopping.off_signals()
            raise
    stopping.leave()


if __name__ == "__main__":
    main()
