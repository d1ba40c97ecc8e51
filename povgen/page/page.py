"""Make the teaching page: the live view beside the geometry and the equations of the paper. It is one HTML file.

The page's text and scripts are in povgen/page/. It needs no network. POV-Ray's movies are files beside it.
"""

import os
from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from povgen import fonts, limits
from povgen.errors import InputError
from povgen.files import checked_output
from povgen.inputs.pieces import PIECES, Piece, PieceFile, radius
from povgen.liveview.scripts import script
from povgen.liveview.values import values
from povgen.optics import uncertainty
from povgen.page import items, rooms
from povgen.page.address import ALL_KINDS, CHOICES, KEPT, PAGES, RANGES, SWITCHES
from povgen.progress import say
from povgen.record import check_unasked, recorded_call, save
from povgen.rendering.parallel import worker_count
from povgen.rendering.volumes import Volume, stored, volumes
from povgen.scene.laws import to_live
from povgen.scene.presets import PEDESTAL_EDGE, AxialScene, Chess, Spheres, input_files
from povgen.scene.presets import pieces as pieces_of
from povgen.scene.sdl import PACKAGE, to_html
from povgen.scene.spec import MovieSpec
from povgen.settings import Rendering
from povgen.sheets.sheet import Sheet
from povgen.validation import as_flag
from povgen.video import build

MOVIES = ("vary-alpha", "vary-z1", "spheres")  # the paper's movies, in its order
MOUNTAINS = Path(__file__).with_name("mountains.webp")  # smaller than that of pictures
FACES = 60  # the page follows a ray through at most so many faces of prisms


@recorded_call
def demo(
    output: str | Path | None = None,
    *,
    pieces: Piece | Sequence[Piece] = (),
    add: str | Path | Sequence[str | Path] = (),
    sky: str | Path | None = None,
    floor: str | Path = "tiles",
    movies: bool = False,
    workers: int | None = None,
    progress: bool = True,
    **options: object,
) -> Path:
    """Write the page, an .html file (by default demo.html), and return its path.

    `pieces` are files of the user's own chess pieces, one or more. `add` are files with questions, challenges, tours
    and lessons (docs/adding.md), one or more. `sky` and `floor` are those of `Chess`. With
    `movies`, POV-Ray's movies are rendered as well. Their names are the page's name and the movie's, as in
    demo-vary-alpha.mp4. `workers` pieces are measured at once, and as many frames rendered; `progress=False` shows no
    progress bar. Options are the fields of `Rendering`: `timeout` is also for each piece, the others are for the
    movies. Raises InputError for a request that is not allowed, before anything is rendered, and for an empty piece.
    Raises PovrayError if POV-Ray fails.
    """
    own = pieces if isinstance(pieces, (list, tuple)) else [pieces]
    scenes = [Chess(piece=piece) for piece in (*PIECES, *own)]  # in one scene they would overlap
    first = {"chess": Chess(sky=sky, floor=floor), "spheres": Spheres(sky=sky)}
    added: list[str | Path] = [add] if isinstance(add, (str, Path)) else [*add]
    inputs: list[str | Path] = [*input_files([*scenes, *first.values()]), *added]
    page = checked_output("demo.html" if output is None else output, [".html"], inputs=inputs)
    workers, movies, progress = worker_count(workers), as_flag("movies", movies), as_flag("progress", progress)
    given: dict[str, Any] = options
    check_options(movies, given)
    specs = {name: _for_page(MovieSpec.load(name)) for name in MOVIES}
    files = {name: page.with_name(f"{page.stem}-{name}.mp4") for name in MOVIES} if movies else {}
    rendering = Rendering(**given)
    quality = rendering.quality
    for name, file in files.items():
        build.checked_movie(file, specs[name].count(quality), specs[name].rate(quality), rendering, inputs)
    check_unasked([*files.values(), *([page] if output is None else [])])
    shown = {name: piece for scene in scenes for name, piece in pieces_of(scene).items()}
    items.load(added, shown)  # before anything is measured
    shapes = volumes(shown, workers=workers, timeout=rendering.timeout, progress=progress)
    for name, piece in shown.items() if progress else ():
        if isinstance(piece, PieceFile) and piece.is_mesh:
            note = f"{piece.note}; " if piece.note else ""
            say(f"povgen: piece = {name!r}: {note}the page shows it on a grid of {shapes[name].place[3]:.2g} tiles")
    for name, file in files.items():
        build.movie(specs[name], file, workers=workers, progress=progress, **{"caption": "none", **given})
    presets = [_preset(name, spec, files.get(name), quality) for name, spec in specs.items()]
    laws = to_live()
    made = data(shown, shapes, presets, first, added)
    poster = "" if sky or str(floor) != "tiles" else b64encode((PACKAGE / "page/poster.webp").read_bytes()).decode()
    text = to_html("page/index", made, script("page/main.js", laws=laws), laws, MOUNTAINS, fonts.encoded(), poster)
    save(text.encode(), page)
    return page


def data(
    shown: Mapping[str, str | PieceFile],
    shapes: Mapping[str, Volume] | None = None,
    presets: Sequence[object] = (),
    scenes: Mapping[str, AxialScene] | None = None,
    added: Iterable[str | Path] = (),
) -> dict[str, object]:
    """Return what the page's scripts read: its scenes, the pieces by their names, presets, and what a lesson has."""
    shown_items = items.load(added, shown)
    return {
        "scenes": {name: values(scene) for name, scene in (scenes or {"chess": Chess(), "spheres": Spheres()}).items()},
        "faces": FACES,
        "languages": items.tables(shown_items),
        **{name: items.data(shown_items, name) for name in ("questions", "tours", "lessons")},
        "choices": CHOICES,
        "ranges": RANGES,
        "switches": SWITCHES,
        "kinds": {name: _kind(kind) for name, kind in ALL_KINDS.items()},
        "parameters": PAGES,
        "pieces": list(shown),
        "feet": {name: radius(piece) for name, piece in shown.items()},
        "pedestals": {name: radius(piece) + PEDESTAL_EDGE for name, piece in shown.items()},
        "volumes": stored(shapes or {}),
        "presets": presets,
        "rooms": rooms.data([*shown]),
        "limits": {
            "condition": limits.MAX_CONDITION,
            "error": limits.MAX_ERROR,
            "radii": uncertainty.RADII,
            "prisms": limits.MAX_PRISMS,
            "designed": limits.MIN_DESIGNED_FRACTION,
            "moire": [limits.MOIRE, limits.MOIRE_COUNT],
        },
    }


def _kind(kind: type[Sheet]) -> dict[str, Any]:
    """Return the values with which a kind of sheets begins, those of its movies, and its parameters."""
    return {
        "sweep": kind.sweep,
        "opening": {each.name: each.default for each in kind.parameters if each.name not in KEPT} | {**kind.opening},
        "parameters": [each.name for each in kind.parameters if each.name not in KEPT],
    }


def check_options(movies: bool, options: dict[str, Any]) -> None:
    """Raise InputError for options of a rendering (except `timeout`) if no movie is rendered, and for two eyes."""
    rendering = Rendering(**options)
    if rendering.stereo != "none":
        raise InputError(f"stereo = {rendering.stereo!r}: the page shows what one eye sees; allowed: 'none'")
    for name, value in options.items():
        if not movies and name != "timeout":
            raise InputError(f"{name} = {value}: only movies are rendered; allowed: with --movies")


def _for_page(spec: MovieSpec) -> MovieSpec:
    """Return the movie without easing and hold: then the page can find a frame by the parameter's value.

    The view is the page's. The direct image is left out, because the page does not have it.
    """
    fixed = {name: value for name, value in spec.fixed.items() if name not in ("view", "direct_image")}
    return spec.replace(ease=False, hold=0.0, fixed=fixed)


def _preset(name: str, spec: MovieSpec, file: Path | None, quality: str) -> dict[str, Any]:
    """Return a movie's data: its scene, the parameter that changes, and POV-Ray's file with its number of frames."""
    (sweep,) = spec.sweep
    start, stop = sweep.ends
    return {
        "name": name,
        "title": spec.title,
        "scene": spec.scene,
        "fixed": spec.fixed,
        "parameter": sweep.parameter,
        "start": start,
        "stop": stop,
        "log": sweep.spacing == "log",
        "seconds": spec.count("standard") / spec.rate("standard"),
        "movie": file and {"file": quote(os.fsencode(file.name)), "frames": spec.count(quality)},
    }
