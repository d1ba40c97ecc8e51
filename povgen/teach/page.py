"""Make the teaching page: movies, frame by frame, beside the diagram of figure 5. The page needs no network."""

import fcntl
import os
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

from povgen.errors import InputError
from povgen.files import checked_folder, checked_output, save, work_folder
from povgen.rendering.frames import render_all
from povgen.rendering.parallel import worker_count
from povgen.scene import limits
from povgen.scene.models import Chess, Scene
from povgen.scene.sdl import to_html
from povgen.scene.spec import MovieSpec
from povgen.settings import Rendering
from povgen.video import encode
from povgen.video.still import picture

OWN = ("vary-alpha", "vary-z1", "spheres")  # the paper's movies, in its order
SHEETS = ("detailed", "ideal")
SWEPT = {"alpha": "α from {} to {}°", "z1": "z₁ from {} to {}", "z2": "z₂ from {} to {}"}
GENERATOR = b'<meta name="generator" content="povgen'
# The names of a page's frames. The last part is the digest of the file.
FRAME = re.compile(rb'"frames/([0-9]+-[a-z]+-[a-z]+-[0-9]+-([0-9a-f]{8})\.webp)"')


def demo(
    specs: Sequence[MovieSpec | str | Path],
    folder: str | Path,
    *,
    workers: int | None = None,
    done: Callable[[], object] = lambda: None,
    **options: object,
) -> Path:
    """Render movies through prisms and through the ideal sheet, and write a page of them into a folder.

    Returns the path of the page, index.html. Options are the fields of `Rendering`. `done` is called after each frame.
    Raises InputError for a request that is not allowed, before anything is rendered. Raises PovrayError if POV-Ray
    fails.

    A page always shows its own frames, and all of them: different frames have different names, and the page is written
    after its frames. The frames of an earlier page are then removed, unless the user changed them or the new page
    shows them. All other files in the folder stay.
    """
    rendering = one_eyed(Rendering(**options))
    loaded = [spec if isinstance(spec, MovieSpec) else MovieSpec.load(spec) for spec in specs]
    movies = [scenes(spec, rendering.quality) for spec in loaded]
    if not movies:
        raise InputError("no movies; allowed: one or more")
    workers = worker_count(workers)
    page, frames = checked_page(Path(folder))
    shown = [_movie_data(spec, movie, rendering) for spec, movie in zip(loaded, movies, strict=True)]
    wanted = [
        (f"{number}-{scene.name}-{sheet}-{n:03}", scene, shown[number - 1]["frames"][sheet][n])
        for number, movie in enumerate(movies, 1)
        for sheet in SHEETS
        for n, scene in enumerate(movie[sheet])
    ]
    rendered = render_all([scene for _, scene, _ in wanted], rendering, workers, done)
    with work_folder(frames) as made, closing(rendered):
        for (name, scene, frame_data), views in zip(wanted, rendered, strict=True):
            data = encode.webp(picture(views, scene, rendering))
            file = f"{name}-{_digest(data)}.webp"
            (made / file).write_bytes(data)
            frame_data["file"] = f"{frames.name}/{file}"
        _replace(page, frames, to_html(_page_data(shown)).encode(), made)
    return page


def _replace(page: Path, frames: Path, html: bytes, made: Path) -> None:
    """Move the new frames and then the page to their folder, and remove the frames that only the old page shows."""
    with _locked(page.parent):
        for file in made.glob("*.webp"):
            file.replace(frames / file.name)
        old = page.read_bytes() if page.exists() else b""
        save(html, page)
        for name, digest in set(FRAME.findall(old)) - set(FRAME.findall(html)):
            file = frames / name.decode()
            if file.is_file() and not file.is_symlink() and _digest(file.read_bytes()) == digest.decode():
                file.unlink()


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Wait until no other povgen replaces the page in the folder, and make others wait meanwhile."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):  # some network file systems cannot lock folders
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def _digest(data: bytes) -> str:
    return sha256(data).hexdigest()[:8]


def scenes(spec: MovieSpec, quality: str) -> dict[str, list[Scene]]:
    """Return the scenes of all frames, for each model of the sheets that the page shows. Raises InputError."""
    names = [sweep.parameter for sweep in spec.sweep]
    if len(names) > 1 or names[0] not in SWEPT or spec.loop:
        what = f"sweep of {', '.join(names)}" + ", there and back" * spec.loop
        raise InputError(f"{spec.title!r}: {what}: not for the page; allowed: one sweep of {', '.join(SWEPT)}, no loop")
    try:
        movies = {sheet: spec.with_fixed({"sheet": sheet}).scenes(quality) for sheet in SHEETS}
        if any(len({L for L, _ in scene.objects}) > 1 for frames in movies.values() for scene in frames):
            raise InputError("x: several values, but the page shows objects on one line; allowed: one value")
        if any(scene.background == "transparent" for frames in movies.values() for scene in frames):
            raise InputError("background = 'transparent': allowed on the page: 'sky', 'black' or 'white'")
        return movies
    except InputError as error:
        raise InputError(f"{spec.title!r}: {error}") from None


def one_eyed(rendering: Rendering) -> Rendering:
    """Return the rendering. Raises InputError if it is for two eyes: the page's diagrams are for one."""
    if rendering.stereo != "none":
        raise InputError(f"stereo = {rendering.stereo!r}: the page shows what one eye sees; allowed: 'none'")
    return rendering


def checked_page(folder: Path) -> tuple[Path, Path]:
    """Return the path of the page and of its frames' folder. Raises InputError unless povgen may write both."""
    page = checked_output(checked_folder(folder) / "index.html", [".html"])
    if page.exists() and GENERATOR not in page.read_bytes():
        raise InputError(
            f"output = {str(folder)!r}: povgen did not write the index.html there; allowed: a folder without one"
        )
    return page, checked_folder(folder / "frames")


def _page_data(movies: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the data that the page's script reads. Lengths are in tiles."""
    return {
        "movies": movies,
        "limits": {"condition": limits.MAX_CONDITION, "correction": limits.MAX_CORRECTION},
    }


def _movie_data(spec: MovieSpec, movie: dict[str, list[Scene]], rendering: Rendering) -> dict[str, Any]:
    """Return a movie's data for the page: angles in degrees, lengths in tiles, complex numbers as pairs."""
    scene, sweep = movie["detailed"][0], spec.sweep[0]
    start, stop = sweep.ends
    thing = scene.name.removesuffix("s")
    if isinstance(scene, Chess):
        thing = scene.piece if isinstance(scene.piece, str) else "piece"
    things = thing + "s" * (len(scene.distances) > 1)
    ends = (f"{end:g}".replace("-", "−") for end in (start, stop))
    return {
        "title": spec.title,
        "label": f"{things.capitalize()}, {SWEPT[sweep.parameter].format(*ends)}",
        "thing": thing,
        "marked": f"{thing}'s foot" if isinstance(scene, Chess) else thing,
        "sweep": sweep.parameter,
        "start": start,
        "stop": stop,
        "rate": spec.rate(rendering.quality),
        "ratio": rendering.size[0] / rendering.size[1],
        "prisms": scene.prisms,
        "view": scene.view,
        "prism": {"slab_shift": scene.prism.slab_shift, "separation": scene.prism.separation},
        "L": [scene.L.real, scene.L.imag],
        "E": [scene.E.real, scene.E.imag],
        "powers": getattr(scene, "z1", ()) is None,  # every z1 is 2^n z2
        "frames": {sheet: [_frame_data(scene) for scene in movie[sheet]] for sheet in SHEETS},
    }


def _frame_data(scene: Scene) -> dict[str, Any]:
    radii = [scene.radius(z1) for z1 in scene.distances] if hasattr(scene, "radius") else None
    return {"alpha": scene.alpha, "z2": scene.z2, "z1": scene.distances, "radius": radii}
