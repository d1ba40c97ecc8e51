"""Render pictures of scenes, with captions and overlays if they are wanted."""

import base64
from collections import deque
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, closing
from functools import partial
from itertools import groupby, repeat
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack, overload

from numpy.typing import NDArray
from PIL.Image import Image, fromarray

from povgen import files, record
from povgen.citation import CITE
from povgen.errors import InputError, TransientError, shown
from povgen.inputs.pictures import Picture
from povgen.inputs.pieces import PieceFile
from povgen.progress import bar, parts
from povgen.record import MAX_FRAMES, MAX_PICTURES, PICTURES, Record, command, differing, in_png, recorded_call
from povgen.rendering import light
from povgen.rendering.frames import drawn_by, read_png, render_all
from povgen.rendering.parallel import checked_scheduler, worker_count
from povgen.rendering.views import composed, frames_of, merged, views
from povgen.scene.files import files_in
from povgen.scene.presets import input_files, pieces, with_seen_files
from povgen.scene.scene import Scene, checked_scene, checked_scenes
from povgen.settings import Options, Rendering
from povgen.sheets.profile import ProfileFile
from povgen.validation import as_flag, is_several
from povgen.version import __version__

if TYPE_CHECKING:  # these, and `encode`, are slow to load, and a picture from the cache does not need them
    from povgen.video.caption_strips import Colour
    from povgen.video.caption_texts import Caption
    from povgen.video.side import Extent

MADE_AT_ONCE = 4  # pictures that are read and drawn on at once
MADE_PIXELS = 1 << 25  # if so many pictures have more pixels together, fewer are made at once
MAX_LARGE = (
    2**22
)  # a record holds the pictures of sky, floor and cards only up to this number of bytes; also the meshes


class RenderOptions(Options, total=False):
    """The options of `render`, for type checkers."""

    linear: bool
    workers: int | None
    scheduler: str | None
    progress: bool


@overload
def render(scene: Scene, **options: Unpack[RenderOptions]) -> NDArray[Any]: ...


@overload
def render(scene: Iterable[Scene], **options: Unpack[RenderOptions]) -> list[NDArray[Any]]: ...


def render(
    scene: Scene | Iterable[Scene],
    *,
    linear: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: bool = True,
    **options: Unpack[Options],
) -> NDArray[Any] | list[NDArray[Any]]:
    """Return the scene's picture: (height, width, 3) bytes of red, green and blue, or 4 with alpha if transparent.

    With `linear` it is scene-linear light instead, float32: 1 is white, and highlights are brighter. It is the same as
    bits=32. With bits=16 it is the encoding of sRGB, 0 to 65535.

    Of several scenes, return a list with the picture of each. They are rendered as the frames of a movie are: several
    at once, `workers` at a time, or on the workers of the Dask scheduler with the address `scheduler`.
    `progress=False` shows no progress bar. Other options are the fields of `Rendering`: size=(640, 480), quality="high"
    and others. Raises InputError if an option is not allowed, and PovrayError if POV-Ray fails.
    """
    if as_flag("linear", linear):
        options.setdefault("bits", 32)
    one = not is_several(scene)
    scenes = checked_scenes([scene] if one else scene, MAX_FRAMES)
    rendering, workers, scheduler = Rendering(**options), worker_count(workers), checked_scheduler(scheduler)
    if linear and rendering.bits != 32:
        raise InputError(f"bits = {rendering.bits}: linear light has 32; allowed: one of them")
    scenes = [each.fitted(rendering.size) for each in scenes]
    found: dict[int, NDArray[Any]] = {}
    failure: TransientError | None = None
    with bar("pictures", len(scenes), not as_flag("progress", progress) or one, "pictures") as done:
        for prisms in (True, False):  # they can have different antialiasing
            alike = [number for number, each in enumerate(scenes) if each.has_prisms is prisms]
            made = pictures([scenes[number] for number in alike], rendering, workers, scheduler, done)
            try:
                with closing(made):
                    found |= zip(alike, (each.copy() for each in made), strict=True)  # the caller may write to them
            except TransientError as error:  # the other scenes are still rendered, and kept
                failure = failure or error
    if failure:
        raise failure
    return found[0] if one else [found[number] for number in range(len(scenes))]


def pictures(
    scenes: Sequence[Scene],
    rendering: Rendering,
    workers: int | None = None,
    scheduler: str | None = None,
    done: Callable[[], object] = lambda: None,
    *,
    movie: bool = False,
    notes: Sequence[str] = (),
) -> Generator[NDArray[Any], None, None]:
    """Yield the picture of each scene, in their order, as `render` returns it. Call `done` after each scene.

    Scenes of a `movie` have captions that fit together, and successive equal scenes are rendered once. `notes` may have
    the note of each. `workers` frames are rendered at once, here or by the workers of a Dask scheduler. Raises as
    `render_all` does.
    """
    if not scenes:
        return
    with ExitStack() as opened:
        cluster = None
        if scheduler is not None:
            from povgen.rendering.cluster import Cluster

            cluster = opened.enter_context(Cluster(scheduler, rendering.renderer))
        at_once = workers or (cluster.frames if cluster else None)
        # successive equal scenes of a movie are rendered once
        runs = alike(scenes, notes) if movie else [(each, "", 1) for each in scenes]
        once = [scene for scene, _, _ in runs]
        # Pictures are made in threads while the caller, which may encode, is busy with those before. When all ends, the
        # rendering is stopped before these threads are.
        width, height = rendering.size
        made_at_once = max(1, min(MADE_AT_ONCE, MADE_PIXELS // (width * height)))
        pool = ThreadPoolExecutor(made_at_once)
        opened.callback(pool.shutdown, cancel_futures=True)
        frames = opened.enter_context(closing(render_all(once, rendering, at_once, done, cluster)))
        texts: Sequence[Caption | None] = [None] * len(once)
        shows = said = cut = None
        if movie and (rendering.annotated or any(notes)):
            from povgen.video import caption_texts, overlay, panel, side

            own = [note for _, note, _ in runs] if notes else ()
            texts, said = caption_texts.captions(once, rendering, own), overlay.common_legend(once, rendering)
            cut = panel.is_cut(once, rendering)
        if movie and rendering.side_view:
            shows = side.extent(once, rendering.eye_distance / 2 if rendering.stereo != "none" else 0)
        waiting: deque[tuple[Future[NDArray[Any]], int]] = deque()
        for views, (scene, _, count), caption in zip(frames, runs, texts, strict=True):
            waiting.append((pool.submit(picture, views, scene, rendering, caption, shows, said, cut), count))
            if len(waiting) > made_at_once:
                made, times = waiting.popleft()
                yield from repeat(made.result(), times)
        while waiting:
            made, times = waiting.popleft()
            yield from repeat(made.result(), times)


def alike(scenes: Sequence[Scene], notes: Sequence[str] = ()) -> list[tuple[Scene, str, int]]:
    """Return each run of successive equal scenes, of one note if notes are given: scene, note, and how many it has."""
    pairs = groupby(zip(scenes, notes or repeat("")))  # noqa: B905  (repeat has no end)
    return [(scene, note, len([*same])) for (scene, note), same in pairs]


def show(scene: Scene, **options: Unpack[Options]) -> Image:
    """Return the scene's picture as an image of Pillow's, which Jupyter shows. Options and errors are `render`'s."""
    if (bits := Rendering(**options).bits) != 8:
        raise InputError(f"bits = {bits}: an image of Pillow's has 8; allowed: 8")
    return fromarray(render(checked_scene(scene), **options))


@recorded_call
def save(scene: Scene, path: str | Path, *, progress: bool = True, **options: Unpack[Options]) -> Path:
    """Write the scene's picture to a PNG or EXR file and return its path. The file is written atomically.

    An EXR file has scene-linear light, as `render` returns it with `linear`. A terminal shows how much of the picture
    is there, but not with `progress=False`. Options and errors are `render`'s. Raises InputError, before anything is
    rendered, if the file cannot be written.
    """
    quiet = not as_flag("progress", progress)
    scene, rendering = checked_scene(scene), rendering_for(path, options)
    output = files.checked_output(path, PICTURES, inputs=input_files([scene]))
    target = output.resolve()  # the current folder may change meanwhile
    record.save(as_file(scene, rendering, output.suffix, quiet=quiet), target)
    return output


def rendering_for(path: object, options: Mapping[str, object]) -> Rendering:
    """Return the rendering for a file. By default an EXR file has 32 bits, a PNG file 8.

    Raises InputError if the path has another ending, for an option that is not allowed, and for bits that the file
    cannot have.
    """
    kind, bits = PICTURES[files.as_path(path, PICTURES, "output").suffix.lower()]
    rendering = Rendering(**{"bits": bits[0], **options})
    if rendering.bits not in bits:
        allowed = " or ".join(map(str, bits))
        raise InputError(
            f"bits = {rendering.bits}: {kind} has {allowed}; allowed: {allowed}, or an output with another ending"
        )
    return rendering


def as_file(scene: Scene, rendering: Rendering | None = None, ending: str = ".png", *, quiet: bool = True) -> bytes:
    """Return the scene's picture as the bytes of a file with this ending, which can have the rendering's bits.

    With `quiet=False`, a terminal shows how much of the picture is there. Raises InputError for a request that is not
    allowed, and PovrayError if POV-Ray fails.
    """
    rendering = rendering or Rendering()
    if rendering.bits == 32:
        light.exr()  # raises an error before anything is rendered
    scene = scene.fitted(rendering.size)
    made = record_of([scene], rendering)
    frames = _frames(scene, rendering, quiet)
    if ending.lower() == ".png" and len(frames) == 1 and not draws_on(scene, rendering) and not rendering.is_light:
        return in_png(frames[0], made)

    from povgen.video import encode

    return encode.PICTURES[ending.lower()](picture(frames, scene, rendering), made)


def record_of(
    scenes: Sequence[Scene],
    rendering: Rendering | None = None,
    title: str | None = None,
    frame_rate: float | None = None,
    notes: Sequence[str] = (),
) -> Record:
    """Return the record of a picture, or of a movie with this title, frame rate and notes of its frames.

    Without `rendering` it is that of another file that shows the scenes. It has the files that are seen. Raises
    InputError if it would be too large, or if the file of a piece or a profile has two different texts in these
    scenes. Raises what `drawn_by` raises.
    """
    scenes = [with_seen_files(scene) for scene in scenes]
    texts: dict[str, str] = {}
    meshes: dict[str, int] = {}  # the sizes
    for scene in scenes:
        for name, piece in pieces(scene).items():
            if isinstance(piece, PieceFile) and texts.setdefault(name, piece.text) != piece.text:
                raise InputError(f"piece = {shown(name)}: the file has changed; allowed: scenes with one text of it")
            if isinstance(piece, PieceFile) and piece.is_mesh:
                meshes[name] = len(piece.text)
        for profile in (file for file in files_in(scene) if isinstance(file, ProfileFile)):
            if texts.setdefault(str(profile), profile.text) != profile.text:
                raise InputError(f"profile = {shown(str(profile))}: its name has two texts; allowed: one text of it")
    if sum(meshes.values()) > MAX_LARGE:
        texts = {name: text for name, text in texts.items() if name not in meshes}
    drawn: dict[str, Any] = {}
    if rendering:
        rendering = rendering.suited(any(scene.has_prisms for scene in scenes))
        drawn = {"renderer": drawn_by(rendering.renderer), "rendering": rendering.model_dump()}
        drawn |= {"title": title, "frame_rate": frame_rate, "notes": notes}
    made = Record(
        povgen=__version__,
        cite=CITE,
        command=command(),
        **drawn,
        pieces=texts,
        pictures=_small_pictures(scenes),
        frames=differing([{"scene": scene.name, **scene.model_dump(mode="json")} for scene in scenes]),
    )
    bytes(made)  # refuses what is too large before anything is rendered
    return made


def _small_pictures(scenes: Sequence[Scene]) -> dict[str, str]:
    """Return the pictures of sky, floor and cards for the record: up to MAX_PICTURES, with up to MAX_LARGE bytes."""
    every = (file for scene in scenes for file in files_in(scene) if isinstance(file, Picture))
    files = {str(picture): picture.file.content for picture in every}
    small = len(files) <= MAX_PICTURES and sum(map(len, files.values())) <= MAX_LARGE
    return {name: base64.b64encode(png).decode() for name, png in files.items()} if small else {}


def picture(
    frames: Sequence[bytes],
    scene: Scene,
    rendering: Rendering,
    caption: "Caption | None" = None,
    shows: "Extent | None" = None,
    said: "Sequence[tuple[str, Colour]] | None" = None,
    cut: bool | None = None,
) -> NDArray[Any]:
    """Return the scene's picture from the rendered frames of its `views`, as `render` does.

    Each frame gets the overlay, the caption and the side view that `rendering` asks for. In a movie, `caption`, `shows`
    (the extent of the side view), `said` (the legend) and `cut` (`panel.is_cut`) must be given, because they depend on
    all scenes of the movie.
    """
    if rendering.is_light:
        pictures = merged(frames, lambda each: light.unpacked(each, rendering.size), scene, rendering)
        made = composed(pictures, scene, rendering)
        return made if rendering.bits == 32 else light.as_16_bits(made)
    pictures = merged(frames, read_png, scene, rendering)
    if caption or draws_on(scene, rendering):
        from povgen.video import overlay, panel, side

        shown = views(scene, rendering)
        said = overlay.common_legend([scene], rendering) if said is None else said
        cut = panel.is_cut(shown, rendering) if cut is None else cut
        draws = [partial(side.side_view, view, shows=shows) if rendering.side_view else None for view in shown]
        add = partial(panel.beside, cut=cut) if rendering.is_wide else overlay.annotated
        every = zip(pictures, shown, draws, strict=True)
        pictures = [add(each, view, rendering, caption, said, draw) for each, view, draw in every]
    return composed(pictures, scene, rendering)


def draws_on(scene: Scene, rendering: Rendering) -> bool:
    """Whether povgen draws on the rendered picture."""
    return rendering.annotated or bool(scene.outlines)


def _frames(scene: Scene, rendering: Rendering, quiet: bool = True) -> list[bytes]:
    with (
        parts(scene.name, len(frames_of(scene, rendering)), quiet) as part,
        closing(render_all([scene], rendering, part=part)) as rendered,
    ):
        return next(rendered)
