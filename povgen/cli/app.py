"""The command line: reads options, calls the package, reports. All checking is done by the models it calls."""

import inspect
import os
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from povgen import __version__, stopping
from povgen.errors import InputError, PovrayError, validated

if TYPE_CHECKING:
    from pydantic.fields import FieldInfo

    from povgen.rendering.settings import Rendering
    from povgen.scene.models import Scene

app = typer.Typer(
    name="povgen",
    help="POV-Ray scenes and movies of ray-rotating Dove-prism sheets. Lengths in floor tiles, angles in degrees.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

SceneName = Annotated[str, typer.Argument(metavar="SCENE", help="chess or spheres")]
Output = Annotated[Path | None, typer.Option("-o", "--output", metavar="FILE", help="the file to write")]
Workers = Annotated[
    str | None,
    typer.Option(metavar="N", help="POV-Ray processes at once, 1 to 256", show_default="enough to keep the cores busy"),
]
Tolerance = Annotated[
    str | None,
    typer.Option(metavar="ERROR", help="for --sheet auto: 1px (of position), 0.2flip (of the picture), or 1px,0.2flip"),
]
Quiet = Annotated[bool, typer.Option("--quiet", help="print errors only")]


def _takes(*models: str) -> Callable:
    """Give a command, in place of its **values, an option for every field of the models: text, or --x and --no-x.

    'scenes' stands for all scenes, 'rendering' for Rendering. The command gets a dictionary of what was given. Only the
    command that is named on the command line gets its options: the models are slow to load.
    """

    def decorate(command: Callable) -> Callable:
        own = [p for p in inspect.signature(command).parameters.values() if p.kind is not p.VAR_KEYWORD]
        fields = _fields(models) if command.__name__ in sys.argv else {}

        def called(**arguments):
            given = {name: arguments.pop(name) for name in fields}
            if given.get("z1") and len(given["z1"]) == 1:
                given["z1"] = given["z1"][0]
            given = {name: value for name, value in given.items() if value not in (None, [])}
            return command(**arguments, **given)

        parameters = [*own, *(_option(name, owners) for name, owners in fields.items())]
        parameters = [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in parameters]
        called.__dict__["__signature__"] = inspect.Signature(parameters)
        called.__annotations__ = {p.name: p.annotation for p in parameters}
        called.__name__, called.__doc__ = command.__name__, command.__doc__
        return called

    return decorate


def _fields(models: tuple[str, ...]) -> dict[str, list[tuple[str, "FieldInfo"]]]:
    """Every field's name, with the names of the scenes that have it ('' for Rendering) and what it is in each."""
    from povgen.rendering.settings import Rendering
    from povgen.scene.models import SCENES

    fields: dict[str, list] = {}
    named = {"scenes": SCENES.values(), "rendering": [Rendering]}
    for model in [model for name in models for model in named[name]]:
        for name, field in model.model_fields.items():
            fields.setdefault(name, []).append((getattr(model, "name", ""), field))
    return fields


def _option(name: str, owners: list[tuple[str, "FieldInfo"]]) -> inspect.Parameter:
    texts = {_about(field): owner for owner, field in owners}
    about = " ".join(f"{owner}: {text}." if len(texts) > 1 else text for text, owner in texts.items())
    kind: Any
    if owners[0][1].annotation is bool:
        kind, info = bool, typer.Option(f"--{name}/--no-{name}", help=about)
    else:
        # the spheres' scene takes several z1
        kind, info = list[str] if name == "z1" else str, typer.Option(f"--{name}", help=about, metavar=name.upper())
    # None: not given, so that a movie's spec decides
    annotation = Annotated[kind | None, info]
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=annotation)


def _about(field: "FieldInfo") -> str:
    from pydantic_core import PydanticUndefined

    default = field.default
    if isinstance(default, tuple):
        default = ",".join(f"{x:g}" for x in default)
    about = field.description or ""
    return about if default in (None, False, PydanticUndefined) else f"{about} (default {default})"


def _scene(name: str, values: dict[str, Any]) -> "Scene":
    from povgen.scene.models import SCENES

    if name not in SCENES:
        raise InputError(f"scene = {name!r}: unknown; allowed: {', '.join(SCENES)}")
    return validated(SCENES[name], values)


def _split(values: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The values of the scene and those of the rendering."""
    from povgen.rendering.settings import Rendering

    rendering = {name: values.pop(name) for name in Rendering.model_fields if name in values}
    return values, rendering


@app.command("list")
def list_() -> None:
    """List scenes with their parameters, chess pieces, and the movies that come with povgen."""
    from povgen.scene.models import PIECES, SCENES
    from povgen.scene.spec import MOVIES, MovieSpec

    for name, scene in SCENES.items():
        print(f"{name}: {scene.subject}")
        for field, info in scene.model_fields.items():
            print(f"    --{field:8} {info.description}")
    print(f"pieces: {', '.join(PIECES)}")
    for path in sorted(MOVIES.glob("*.toml")):
        print(f"movie {path.stem}: {MovieSpec.load(path).title}")


@app.command()
@_takes("scenes")
def pov(scene: SceneName, output: Output = None, **values) -> None:
    """Write a scene's POV-Ray source, to standard output unless -o says where."""
    from povgen.files import checked_output, save
    from povgen.scene.sdl import to_pov

    made = _scene(scene, values)
    text = to_pov(made)
    _warn([made])
    if output is None:
        print(text, end="")
    else:
        save(text.encode(), checked_output(output, [".pov"]))


@app.command()
@_takes("scenes", "rendering")
def frame(
    scene: SceneName,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FILE", help="the file to write")] = Path(
        "frame.png"
    ),
    tolerance: Tolerance = None,
    quiet: Quiet = False,
    **values,
) -> None:
    """Render a scene to a PNG file. With --sheet auto and --tolerance through the cheapest sheets that will do."""
    from povgen.files import checked_output, save
    from povgen.rendering import cache
    from povgen.rendering.frames import png
    from povgen.rendering.settings import Rendering

    values, options = _split(values)
    output = checked_output(output, [".png"])
    chosen = _auto(values, options, tolerance, quiet, lambda values, quality: [_scene(scene, values)])
    made = _scene(scene, values | chosen)
    rendering = validated(Rendering, options)
    cache.check()
    if not quiet:
        _warn([made], rendering)
    save(png(made, rendering), output)
    if not quiet:
        print(f"wrote {output}")


@app.command()
@_takes("scenes", "rendering")
def movie(
    spec: Annotated[
        str, typer.Argument(metavar="SPEC", help="a movie's TOML file, or the name of one of povgen's own")
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help=".mp4, .webm or .gif (default SPEC's name with .mp4, in the current folder)",
        ),
    ] = None,
    workers: Workers = None,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="of a Dask scheduler, tcp://HOST:PORT, whose workers render"),
    ] = None,
    part: Annotated[
        str | None,
        typer.Option("--shard", metavar="I/N", help="render every N-th frame, from the I-th on, and no movie yet"),
    ] = None,
    tolerance: Tolerance = None,
    quiet: Quiet = False,
    **values,
) -> None:
    """Render a movie. Options for the scene take the place of what the spec fixes. Finished frames are kept."""
    import logging

    from povgen.rendering import cache
    from povgen.rendering.frames import render_all, shard
    from povgen.rendering.settings import Rendering
    from povgen.scene.spec import MovieSpec
    from povgen.video.build import checked_movie
    from povgen.video.build import movie as make

    values, options = _split(values)
    loaded, count = MovieSpec.load(spec), _workers(workers)
    output = output or Path(f"{'movie' if spec == '-' else Path(spec).stem}.mp4")
    if part is None:
        checked_movie(output, loaded, validated(Rendering, options).quality)
    elif scheduler is not None:
        raise InputError(f"shard = {part!r}, scheduler = {scheduler!r}: allowed: one of them")
    chosen = _auto(values, options, tolerance, quiet, lambda values, q: loaded.with_fixed(values).scenes(q))
    made = loaded.with_fixed(values | chosen)
    rendering = validated(Rendering, options)
    scenes = made.scenes(rendering.quality)
    if part is not None:
        scenes = shard(scenes, part)
    cache.check()
    if not quiet:
        _warn(scenes, rendering)
    if part is not None:
        with _progress(f"shard {part}", len(scenes), quiet) as done:
            for _ in render_all(scenes, rendering, count, done):
                pass
        if not quiet:
            print(f"rendered shard {part}: {len(scenes)} frames")
        return
    if quiet:
        logging.getLogger("povgen").setLevel("ERROR")
    with _progress(output.name, len(scenes), quiet) as done:
        make(made, output, workers=count, done=done, scheduler=scheduler, **options)
    if not quiet:
        print(f"wrote {output}")


@app.command()
@_takes("rendering")
def demo(
    specs: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SPEC]...", help="movies' TOML files, or names of povgen's own", show_default="the paper's three"
        ),
    ] = None,
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FOLDER", help="for index.html and its frames")
    ] = Path("demo"),
    workers: Workers = None,
    quiet: Quiet = False,
    **options,
) -> None:
    """Make a page to teach with: each movie through prisms and the ideal sheet, beside figure 5's diagram."""
    from povgen.rendering import cache
    from povgen.rendering.settings import Rendering
    from povgen.scene.spec import MovieSpec
    from povgen.teach.page import OWN, checked_page, scenes
    from povgen.teach.page import demo as make

    loaded, count = [MovieSpec.load(spec) for spec in specs or OWN], _workers(workers)
    rendering = validated(Rendering, options)
    shown = [scene for spec in loaded for frames in scenes(spec, rendering.quality).values() for scene in frames]
    cache.check()  # would be asked for when the folder is there
    checked_page(output)
    if not quiet:
        _warn(shown, rendering)
    with _progress(output.name, len(shown), quiet) as done:
        page = make(loaded, output, workers=count, done=done, **options)
    if not quiet:
        print(f"wrote {page}")


@app.command()
def check() -> None:
    """See whether POV-Ray and the encoder work, with a small frame and movie; say what to do where they do not."""
    from povgen.cli.checkup import faults

    if list(faults(print)):
        raise typer.Exit(1)


@app.command()
def cache(
    what: Annotated[str, typer.Argument(metavar="info|clear", help="tell of the frames that are kept, or remove them")],
) -> None:
    """The frames that are kept, up to POVGEN_CACHE_SIZE GiB (2) in POVGEN_CACHE: the least recently used go first.

    And what povgens that were killed left, in that folder and among temporary files.
    """
    from povgen.rendering import cache

    if what not in ("info", "clear"):
        raise InputError(f"{what!r}: allowed: info or clear")
    cache.check()
    if what == "clear":
        print(f"removed {_kinds(cache.trim(-1))} from {cache.folder()}")
        if swept := cache.sweep():
            print(f"removed {swept} folders that killed povgens left")
    else:
        files = cache.entries()
        size = sum(size for _, size, _ in files) / 2**30
        kinds = _kinds([path for _, _, path in files])
        print(f"{kinds}, {size:.3f} of {cache.limit() / 2**30:g} GiB, in {cache.folder()}")
        if left := cache.left():
            print(f"{len(left)} folders that killed povgens left, {sum(left) / 2**30:.3f} GiB")


def _kinds(files: list[Path]) -> str:
    frames = sum(path.suffix == ".png" for path in files)
    return f"{frames} frames and {len(files) - frames} ray traces"


@app.command()
def verify(
    sheet: Annotated[str | None, typer.Option(metavar="ideal|detailed", help="one sheet model (default both)")] = None,
    json: Annotated[Path | None, typer.Option(metavar="FILE", help="write the figures to a .json file as well")] = None,
    stability: Annotated[
        bool, typer.Option("--stability", help="map where methods fail, and measure the limits")
    ] = False,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FOLDER", help="for the maps (default stability)")
    ] = None,
) -> None:
    """Measure what POV-Ray renders against the equations and the exact ray trace; exit status 1 where a bound fails."""
    from dataclasses import asdict
    from json import dumps
    from math import isfinite

    from rich.console import Console
    from rich.live import Live
    from rich.table import Table

    from povgen.files import checked_output, save
    from povgen.rendering import povray

    if sheet not in (None, "ideal", "detailed"):
        raise InputError(f"sheet = {sheet!r}: allowed: ideal or detailed")
    if output and not stability:
        raise InputError(f"output = {str(output)!r}: it is for the maps; allowed with --stability")
    if json:
        json = checked_output(json, [".json"])
    versions = {"povgen": __version__, "POV-Ray": povray.version()}
    table = Table("sheet", "measured", "value", "bound", "", title=f"povgen {__version__}, POV-Ray {povray.version()}")
    figures = []
    with Live(table, console=Console(width=None if sys.stdout.isatty() else 120), auto_refresh=False) as live:

        def add(figure) -> None:
            bound = f"{'≥' if figure.least else '≤'} {figure.bound:.5g} {figure.unit}"
            holds = "ok" if figure.holds else "[red]FAILS[/red]"
            table.add_row(figure.sheet, figure.what, f"{figure.value:.5g} {figure.unit}", bound, holds)
            value = figure.value if isfinite(figure.value) else None
            figures.append(asdict(figure) | {"value": value, "holds": figure.holds})
            live.refresh()

        if stability:
            from povgen.measure.charts import save_maps
            from povgen.measure.stability import maps

            save_maps(maps(sheet), _folder(output or Path("stability")), add)
        else:
            from povgen.measure.verify import checks

            for figure in checks(sheet):
                add(figure)
    if json:
        save((dumps({"versions": versions, "figures": figures}, indent=2, default=float) + "\n").encode(), json)
    if not all(figure["holds"] for figure in figures):
        raise typer.Exit(1)


@app.command()
def chart(
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FOLDER", help="for charts and tables")] = Path(
        "chart"
    ),
    peers: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="of other ways to write the prisms, as .inc files")
    ] = None,
) -> None:
    """Measure CPU seconds against error, for every model and sampling; charts and tables, in some 20 minutes."""
    from povgen.files import save
    from povgen.measure import charts, speed

    by_hand = speed.rewrites(peers) if peers else {}
    folder = _folder(output)
    charts.save_frames(speed.frames(by_hand, _say), folder)
    charts.save_counts(list(speed.prism_counts(_say)), folder)
    charts.save_movies(list(speed.movies(speed.WORKERS, _say)), folder)
    save(f"{speed.machine()}\n".encode(), folder / "machine.txt")


@app.command()
def figure(
    numbers: Annotated[list[str], typer.Argument(metavar="NUMBER...", help="of figures in the paper, 1 to 6")],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FOLDER", help="for pictures and captions")] = Path(
        "figures"
    ),
    quality: Annotated[str, typer.Option(metavar="QUALITY", help="of frames: draft, paper or high")] = "high",
) -> None:
    """Make figures of the paper: PNG, drawings also as SVG, and a caption with the measured agreement."""
    from povgen.rendering.settings import Rendering

    rendering = validated(Rendering, {"quality": quality})
    for number in numbers:
        if number not in list("123456"):
            raise InputError(f"number = {number!r}: no figure of the paper; allowed: 1 to 6")
    folder = _folder(output)
    from povgen.teach.figures import save_figure  # after what can be refused, for matplotlib is slow to load

    for number in numbers:
        for path in save_figure(int(number), folder, rendering):
            print(f"wrote {path}")


@app.callback(invoke_without_command=True)
def _version(version: Annotated[bool, typer.Option("--version", help="print povgen's version")] = False) -> None:
    if version:
        print(f"povgen {__version__}")
        raise typer.Exit


def _auto(
    values: dict[str, Any],
    options: dict[str, Any],
    tolerance: str | None,
    quiet: bool,
    scenes: Callable[[dict[str, Any], str], list["Scene"]],
) -> dict[str, str]:
    """The sheet in place of 'auto', if that is what was given; puts the antialiasing chosen into the options."""
    if (values.get("sheet") == "auto") != (tolerance is not None):
        raise InputError("sheet = 'auto' and tolerance go together; allowed: both, as --sheet auto --tolerance 1px")
    if tolerance is None:
        return {}
    from povgen.measure import auto
    from povgen.rendering.settings import Rendering

    limit = auto.Tolerance.parse(tolerance)
    rendering = validated(Rendering, options)
    through = scenes(values | {"sheet": "detailed"}, rendering.quality)
    chosen, why = auto.choose(through, rendering, limit, options.get("antialias"))
    if not quiet:
        _say(f"povgen: {why}")
    options["antialias"] = chosen.antialias
    return {"sheet": chosen.sheet}


def _warn(scenes: list["Scene"], rendering: "Rendering | None" = None) -> None:
    """Say once, of each limit that frames cross, what it is and how many do."""
    from povgen.scene.limits import warnings

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
        _say(f"povgen: warning: {texts[0]}{also}")


def _folder(output: Path) -> Path:
    """A folder that is made, when there is nothing left to refuse."""
    from povgen.files import checked_folder
    from povgen.rendering import cache

    cache.check()
    return checked_folder(output)


def _workers(text: str | None) -> int | None:
    if text is None:
        return None
    if not re.fullmatch("[0-9]{1,9}", text) or not 1 <= int(text) <= 256:
        raise InputError(f"workers = {text!r}: allowed: a whole number from 1 to 256")
    return int(text)


@contextmanager
def _progress(what: str, total: int, quiet: bool) -> Iterator[Callable[[], None]]:
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
                _say(f"{what}: {count}/{total} frames")

        yield line


def main() -> None:
    """Run the command line; exit status 2 for input that cannot be, 1 where POV-Ray or the disk fails."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:  # closed, as by 2>&-: the next file that is opened would take its number
            setattr(sys, name, open(os.devnull, mode))
    if isinstance(sys.stdout, TextIOWrapper):  # a file's name need not be text
        sys.stdout.reconfigure(errors="backslashreplace")
    usage_error = typer.BadParameter.__bases__[0]  # click's, which typer has under another name from release to release
    try:
        status = app(standalone_mode=False)
    except Exception as error:
        if stopping.asked():
            raise
        if isinstance(error, (InputError, usage_error)):
            message = _line(getattr(error, "format_message", error.__str__)())
            _fail(f"povgen: {message}" if message else "", 2)  # typer has said it all where it has printed the help
        if isinstance(error, (PovrayError, OSError)):
            _fail(f"povgen: {error}", 1)
        if isinstance(error, MemoryError) or str(error) == "can't start new thread":
            _fail("povgen: no memory or no thread is left for povgen itself (ulimit -v, ulimit -u)", 1)
        raise
    sys.exit(status)


def _line(message: str) -> str:
    """A message that may quote anything, in one line that a terminal shows as it is; of a long one the ends."""
    message = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in message)
    return message if len(message) <= 1000 else f"{message[:500]} ... {message[-400:]}"


def _fail(message: str, status: int) -> None:
    if message:
        _say(message)
    sys.exit(status)


def _say(message: str) -> None:
    """Print on standard error. A message that cannot be written there stops nothing."""
    try:
        print(message, file=sys.stderr, flush=True)
    except OSError:
        sys.stderr = open(os.devnull, "w")  # else Python tries again at its end, and exits with status 120
