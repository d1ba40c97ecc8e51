"""The teaching page: movies, frame by frame, beside the diagram of figure 5, in a folder that needs no network."""

import fcntl
import os
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

from povgen.errors import InputError, validated
from povgen.files import checked_folder, checked_output, save, work_folder
from povgen.optics import prism
from povgen.rendering.frames import render_all
from povgen.scene import limits
from povgen.scene.models import Scene
from povgen.scene.sdl import to_html
from povgen.scene.spec import MovieSpec
from povgen.settings import Rendering
from povgen.video import encode
from povgen.video.still import picture

OWN = ("vary-alpha", "vary-z1", "spheres")  # the paper's movies, in its order
SHEETS = ("detailed", "ideal")
SWEPT = {"alpha": "α from {} to {}°", "z1": "z₁ from {} to {}", "z2": "z₂ from {} to {}"}
GENERATOR = b'<meta name="generator" content="povgen'
# How a page names its frames; the last part is the digest of the file.
FRAME = re.compile(rb'"frames/([0-9]+-[a-z]+-[a-z]+-[0-9]+-([0-9a-f]{8})\.webp)"')


def demo(
    specs: Sequence[MovieSpec | str | Path],
    folder: str | Path,
    *,
    workers: int | None = None,
    done: Callable[[], object] = lambda: None,
    **options,
) -> Path:
    """Render movies through prisms and through the ideal sheet, and write a page of them into a folder.

    Returns the page, index.html. Frames that differ have names that differ, and the page is written after them: it
    always shows its own frames, all of them. Then the frames of the page that was there before are removed, as far as
    they are unchanged and the new page does not show them. What else is in the folder stays.
    Options: those of `Rendering`. `done` is called after each frame.
    Raises InputError for what cannot be before anything is rendered, PovrayError where POV-Ray fails.
    """
    rendering = validated(Rendering, options)
    loaded = [spec if isinstance(spec, MovieSpec) else MovieSpec.load(spec) for spec in specs]
    movies = [scenes(spec, rendering.quality) for spec in loaded]
    if not movies:
        raise InputError("no movies; allowed: one or more")
    page, frames = checked_page(Path(folder))
    told = [_told(spec, movie, rendering) for spec, movie in zip(loaded, movies, strict=True)]
    wanted = [
        (f"{number}-{scene.name}-{sheet}-{n:03}", scene, told[number - 1]["frames"][sheet][n])
        for number, movie in enumerate(movies, 1)
        for sheet in SHEETS
        for n, scene in enumerate(movie[sheet])
    ]
    rendered = render_all([scene for _, scene, _ in wanted], rendering, workers, done)
    with work_folder(frames) as made, closing(rendered):
        for (name, scene, told_frame), frame in zip(wanted, rendered, strict=True):
            data = encode.webp(picture(frame, scene, rendering))
            file = f"{name}-{_digest(data)}.webp"
            (made / file).write_bytes(data)
            told_frame["file"] = f"{frames.name}/{file}"
        _replace(page, frames, to_html(_data(told)).encode(), made)
    return page


def _replace(page: Path, frames: Path, html: bytes, made: Path) -> None:
    """Put the frames made and then the page in their places, and remove the frames that only the old page shows."""
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
    """Wait until no other povgen replaces the page in the folder."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):  # some network file systems have no locks of folders
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def _digest(data: bytes) -> str:
    return sha256(data).hexdigest()[:8]


def scenes(spec: MovieSpec, quality: str) -> dict[str, list[Scene]]:
    """The scenes of all frames, for each model of the sheets that the page shows. Raises InputError."""
    try:
        return {sheet: spec.with_fixed({"sheet": sheet}).scenes(quality) for sheet in SHEETS}
    except InputError as error:
        raise InputError(f"{spec.title!r}: {error}") from None


def checked_page(folder: Path) -> tuple[Path, Path]:
    """The page's path in a folder and that of its frames, if povgen may write both. Raises InputError."""
    page = checked_output(checked_folder(folder) / "index.html", [".html"])
    if page.exists() and GENERATOR not in page.read_bytes():
        raise InputError(f"output = {str(folder)!r}: index.html there is not povgen's; allowed: a folder without one")
    return page, checked_folder(folder / "frames")


def _data(movies: list[dict[str, Any]]) -> dict[str, Any]:
    """What the page's equations need beside the movies; lengths in tiles."""
    return {
        "movies": movies,
        "view_height": Scene.view_height,
        "prism": {"air_gap": prism.AIR_GAP, "aspect": prism.aspect(), "slab_shift": prism.slab_shift()},
        "limits": {"condition": limits.MAX_CONDITION, "correction": limits.MAX_CORRECTION},
    }


def _told(spec: MovieSpec, movie: dict[str, list[Scene]], rendering: Rendering) -> dict[str, Any]:
    """A movie as the page has it: angles in degrees, lengths in tiles, complex numbers as pairs."""
    scene, sweep = movie["detailed"][0], spec.sweep
    thing = getattr(scene, "piece", scene.name.removesuffix("s"))
    things = thing + "s" * (len(scene.distances) > 1)
    ends = (f"{end:g}".replace("-", "−") for end in (sweep.start, sweep.stop))
    return {
        "title": spec.title,
        "label": f"{things.capitalize()}, {SWEPT[sweep.parameter].format(*ends)}",
        "thing": thing,
        "marked": f"{thing}'s foot" if hasattr(scene, "piece") else thing,
        "sweep": sweep.parameter,
        "start": sweep.start,
        "stop": sweep.stop,
        "rate": spec.rate(rendering.quality),
        "ratio": rendering.size[0] / rendering.size[1],
        "prisms": scene.prisms,
        "pitch": scene.pitch,
        "L": [scene.L.real, scene.L.imag],
        "E": [scene.E.real, scene.E.imag],
        "powers": getattr(scene, "z1", ()) is None,  # every z1 is 2^n z2
        "frames": {sheet: [_told_frame(scene) for scene in movie[sheet]] for sheet in SHEETS},
    }


def _told_frame(scene: Scene) -> dict[str, Any]:
    radii = [scene.radius(z1) for z1 in scene.distances] if hasattr(scene, "radius") else None
    return {"alpha": scene.alpha, "z2": scene.z2, "z1": scene.distances, "radius": radii}
