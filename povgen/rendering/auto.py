"""The choice that `--sheet auto` makes: the cheapest model of the sheets and the cheapest sampling within a tolerance.

With `--renderer auto` it is also the choice of the renderer.

A sampling is a value of `Rendering.antialias`, such as '2x' or '1,0.1,2'. The error of positions is predicted: it is
the distance, in the plane z = 0, between two apparent places of a point behind the sheets. The first place is the
paraxial prediction for the prisms. The second place is where the cheaper model shows the point: by eq. 7 (ideal sheet),
or where the straight line from the eye to the point crosses z = 0 (no sheet). The error of the picture is measured as
FLIP (Andersson et al. 2020), a perceptual difference of two pictures, 0 to 1. For this, small blocks of the window are
rendered with each candidate. Each block is compared with the same block of the converged picture. The candidate's
renderer renders that picture through the scene's prisms, with the sampling `flip.CONVERGED`. So POV-Ray is not needed
for the candidates of gl, which are tried first.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from math import inf, isnan, nan, radians, sqrt
from typing import Any, Literal, TypeVar, Unpack, cast

import numpy as np
from numpy.typing import NDArray

from povgen import limits
from povgen.errors import InputError, TransientError, shown
from povgen.files import temporary_folder
from povgen.optics import equations
from povgen.rendering import gl_runner, gl_scene, povray, survey_cache
from povgen.rendering.flip import CONVERGED, flip, flip_evaluator
from povgen.rendering.frames import read_png
from povgen.rendering.light import Picture
from povgen.rendering.parallel import default_workers, thread_pool
from povgen.rendering.views import check_gl, views
from povgen.rendering.volumes import volumes
from povgen.scene import camera
from povgen.scene.presets import AxialScene, checked_axial, pieces
from povgen.scene.scene import Scene
from povgen.scene.sdl import Mosaic, to_pov
from povgen.scene.white import WHITE
from povgen.settings import Options, Renderer, Rendering, SharedOptions
from povgen.validation import is_several

Given = TypeVar("Given", AxialScene, Sequence[AxialScene])
FAR_DISTANCE = 1000.0  # tiles: the distance that represents the horizon and the sky
# Samplings, the cheapest first. The ideal sheet (or no sheet) needs fewer rays than prisms. The last sampling of the
# ideal sheet costs about as much as the first one of the prisms. All are POV-Ray's own methods, because small
# blocks estimate their FLIP to a few percent. Blocks estimate the FLIP of 1.5x to 4x only to 10 to 20 %, because the
# filter needs pixels beyond a block's edge.
IDEAL_SAMPLINGS = ("off", "1,0.1,2", "1,0.1,4")
PRISM_SAMPLINGS = ("off", "1,0.9,2", "1,0.5,2", "1,0.1,2", "1,0.1,3", "1,0.1,4")
# Through prisms, the renderer gl uses 2x to 4x: with as many rays, samplings like 1,0.1,3 have a greater error. Around
# its blocks it draws the pixels that the filter needs.
GL_PRISM_SAMPLINGS = ("off", "2x", "3x", "4x")
RENDERERS = ("gl", "povray")  # the cheapest first: for the same sheets, gl needs a tenth to a third of the CPU time
# A mosaic is a small picture: blocks of the window's pixels, side by side.
MAX_SHARE = 0.11  # the fraction of the window's pixels that a mosaic contains, within the limits of MOSAIC_SIDES
BLOCK_SIDE = 10  # pixels, approximately: many small blocks represent the window better than a few large blocks
BLOCK_SIDE_GL = 20  # gl draws each block as a picture of its own
EDGE = 2  # pixels around such a block, for the filter
MIN_BLOCKS = 4  # blocks in a row and in a column
MOSAIC_SIDES = 20, 100  # limits of a mosaic's side, pixels; it is smaller after rounding, or in a smaller window
MAX_FRAMES = 8  # the greatest number of a movie's frames that are tried
MARGIN_FACTOR = 1.5  # mean FLIP of the blocks + this factor * its standard error must be within the tolerance
ALLOWED_TOLERANCES = "allowed: pixels (1px), mean FLIP (0.2flip), or both (1px,0.2flip)"


@dataclass(frozen=True)
class Tolerance:
    """The greatest allowed errors: `px` of positions, in pixels; `flip` of the picture, mean FLIP in the window."""

    px: float = inf
    flip: float = inf

    @classmethod
    def parse(cls, text: str) -> "Tolerance":
        """Parse text such as '1px', '0.2flip', '1px,0.2flip'. Raises InputError."""
        given = {}
        for part in str(text).split(","):
            match = re.fullmatch(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*(px|flip)\s*", part, re.ASCII)
            if not match or match[2] in given or not 0 < float(match[1]) < inf:
                raise InputError(f"tolerance = {shown(text)}: not a tolerance; {ALLOWED_TOLERANCES}")
            given[match[2]] = float(match[1])
        return cls(**given)


@dataclass(frozen=True)
class Candidate:
    """A renderer, a model of the sheets and a sampling, with the errors of a picture that is made with them.

    `px` is the error of positions, in pixels. `flip` is the mean FLIP, estimated from blocks. `margin` is its
    uncertainty: MARGIN_FACTOR standard errors. `flip` and `margin` are NaN if the candidate was not tried.
    """

    sheet: str
    antialias: str
    px: float
    flip: float = nan
    margin: float = nan
    renderer: str = "povray"

    def __str__(self) -> str:
        flip = "" if isnan(self.flip) else f", {self.flip:.2g}±{self.margin:.1g} FLIP"
        renderer = "" if self.renderer == "povray" else f"renderer {self.renderer}, "
        return f"{renderer}sheet {self.sheet}, antialias {self.antialias} ({self.px:.2g} px{flip})"


class _MosaicRendering(Rendering):
    """The rendering of a mosaic, which is allowed to be smaller than other pictures."""

    size: tuple[int, int]


def cheapest(
    scene: Given,
    tolerance: str,
    *,
    renderer: Renderer | Literal["auto"] = "povray",
    **options: Unpack[SharedOptions],
) -> tuple[Given, Options]:
    """Return the scene with the cheapest sheets within a tolerance, and the options of `render` that belong to it.

    This is the choice of --sheet auto among the scene's prisms, the ideal sheet and no sheet, and among samplings. Of
    several scenes, as of a movie, all get the same.
    Example: `scene, options = povgen.cheapest(Chess(), "1px,0.2flip", quality="high")`, and `render(scene, **options)`.
    The tolerance is the largest error of positions in pixels (1px), of the picture as mean FLIP (0.2flip), or both.
    Options are the fields of `Rendering`. With antialias, no other sampling is tried. With renderer="auto", the
    renderer is chosen too. Raises InputError if an argument is not allowed, for several windows, if no choice meets
    the tolerance, and for a tolerance of FLIP if flip-evaluator is missing. Raises PovrayError if POV-Ray fails.
    """
    renderers: Sequence[Any] = RENDERERS if renderer == "auto" else (renderer,)
    limit, rendering = Tolerance.parse(tolerance), Rendering(**{**options, "renderer": renderers[-1]})
    given: list[AxialScene] = [*scene] if is_several(scene) else [scene]  # type: ignore[list-item]
    prisms = [checked_axial(each, "sheet = 'auto'").replace(sheet="detailed") for each in given]
    if not prisms:
        raise InputError("scene: an empty list; allowed: one or more scenes")
    antialias = rendering.sampling if "antialias" in options else None
    choice, _ = choose(prisms, rendering, limit, antialias, renderers)
    chosen = {**options, "antialias": choice.antialias, "renderer": choice.renderer}
    found = [each.replace(sheet=choice.sheet) for each in prisms]
    return cast(Given, found if is_several(scene) else found[0]), cast(Options, chosen)


def choose(
    given: Sequence[Scene],
    rendering: Rendering,
    tolerance: Tolerance,
    antialias: str | None = None,
    renderers: Sequence[str] = ("povray",),
) -> tuple[Candidate, str]:
    """Return the cheapest candidate that meets the tolerance in all scenes, and one line with the reason.

    The scenes have detailed sheets. Positions are predicted in every scene. Pictures are measured in at most MAX_FRAMES
    scenes. If `antialias` is given, no other sampling is tried. Of several renderers, gl is left out if it cannot show
    the scenes or cannot be used here.
    Raises InputError for windows in series and rooms, if no candidate meets the tolerance, and for a tolerance of FLIP
    if flip-evaluator is missing. Raises PovrayError if POV-Ray fails.
    """
    shown = [view for scene in given for view in views(scene.fitted(rendering.size), rendering)]
    if any(scene.pupil or scene.wavelength == WHITE or scene.polarised for scene in shown):
        raise InputError(
            "sheet = 'auto': not with a pupil, polarisers or in white light; allowed: 'detailed', 'ideal' or 'none'"
        )
    scenes = [checked_axial(view, "sheet = 'auto'") for view in shown]
    if any(scene.window for scene in scenes):
        raise InputError("sheet = 'auto': not for several windows; allowed: 'detailed', 'ideal' or 'none'")
    # at alpha = 0 the ideal sheet changes nothing, and the picture without it ("none") is cheaper; but a predicted
    # image needs a sheet
    plain = all(scene.alpha % 360 == 0 and not getattr(scene, "predicted_image", False) for scene in scenes)
    substitute = "none" if plain else "ideal"
    position_errors = {
        sheet: max(_position_error(scene, sheet) * rendering.size[1] / scene.view for scene in scenes)
        for sheet in (substitute, "detailed")
    }
    ladders = [
        [
            Candidate(sheet, sampling, position_errors[sheet], renderer=renderer)
            for sampling in ([antialias] if antialias else samplings)
        ]
        for renderer in renderers
        if len(renderers) == 1 or renderer == "povray" or _gl_can_draw(scenes, rendering.timeout)
        for sheet, samplings in (
            (substitute, IDEAL_SAMPLINGS),
            ("detailed", prism_samplings(renderer)),
        )
    ]
    kept = [ladder for ladder in ladders if ladder[0].px <= tolerance.px]
    reason = f"; {ladders[0][0]} exceeds it" if len(kept) < len(ladders) else ""
    if tolerance.flip == inf:
        return kept[0][0], f"{kept[0][0]}: the cheapest within tolerance{reason}"
    flip_evaluator()  # raises before anything is rendered
    return _cheapest(kept, cache(lambda renderer: _Trial(scenes, rendering, renderer)), tolerance.flip, reason)


def _cheapest(
    ladders: Sequence[list[Candidate]], trial: Callable[[str], "_Trial"], most: float, reason: str
) -> tuple[Candidate, str]:
    """Return the cheapest candidate whose FLIP + margin is at most `most`, and one line with the reason.

    A ladder is a list of candidates, the cheapest first. The ladders are searched in turn, each by bisection. A tried
    candidate is replaced in its ladder by one with its errors. `trial` returns the comparison for a renderer. Raises
    InputError if no candidate is found.
    """
    for ladder in ladders:
        low, high = 0, len(ladder)  # candidates below `low` exceed the tolerance, candidates from `high` up meet it
        while low < high:
            middle = (low + high) // 2
            tried = ladder[middle] = trial(ladder[middle].renderer).of(ladder[middle])
            if tried.flip + tried.margin <= most:
                high = middle
            else:
                low, reason = middle + 1, f"; the next cheaper, {tried}, exceeds it"
        if low < len(ladder):
            return ladder[low], f"{ladder[low]}: the cheapest within tolerance{reason}"
    best = min((c for ladder in ladders for c in ladder if not isnan(c.flip)), key=lambda c: c.flip + c.margin)
    raise InputError(f"tolerance: no choice meets it; the nearest is {best}; allowed: that error or more")


def prism_samplings(renderer: str) -> Sequence[str]:
    """Return the samplings that are tried through prisms, the cheapest first."""
    return PRISM_SAMPLINGS if renderer == "povray" else GL_PRISM_SAMPLINGS


def _gl_can_draw(scenes: Sequence[AxialScene], timeout: float) -> bool:
    """Whether the renderer gl shows these scenes on this machine.

    POV-Ray measures pieces of a user's own for that, for at most `timeout` seconds each. Raises PovrayError if POV-Ray
    fails.
    """
    try:
        for scene in scenes:
            check_gl(scene)
        gl_runner.device()
        volumes({name: piece for scene in scenes for name, piece in pieces(scene).items()}, timeout=timeout)
    except (InputError, TransientError):
        return False
    return True


class _Trial:
    """The comparison of a renderer's candidates with its converged picture, on small blocks of a few windows."""

    def __init__(self, scenes: Sequence[AxialScene], rendering: Rendering, renderer: str) -> None:
        chosen = np.unique(np.linspace(0, len(scenes) - 1, MAX_FRAMES).round().astype(int))
        side = BLOCK_SIDE if renderer == "povray" else BLOCK_SIDE_GL
        self.mosaics = [(scenes[n], found) for n in chosen if (found := mosaic(scenes[n], rendering.size, side))]
        self.size, self.timeout = rendering.size, rendering.timeout
        self.pictures = self._by_povray if renderer == "povray" else self._by_gl
        self.converged = self.pictures("detailed", CONVERGED)

    def of(self, candidate: Candidate) -> Candidate:
        """Return the candidate with its mean FLIP and its margin, from the scene where their sum is greatest."""
        pictures = self.pictures(candidate.sheet, candidate.antialias)
        worst = (0.0, 0.0)  # the result if no window is visible
        for (_, part), picture, converged in zip(self.mosaics, pictures, self.converged, strict=True):
            blocks = _flip(picture, converged, part.side)
            if candidate.sheet == "detailed":
                # FLIP depends on a pixel's surroundings. If a block is surrounded by the mosaic's other blocks, its
                # FLIP is too high (noise at the edges). If it is surrounded by copies of itself, its FLIP is too low by
                # about as much. Both errors are about 3 % (mean of 14 scenes). So the two values are averaged.
                blocks = (blocks + _flip(picture, converged, part.side, part.side // 2)) / 2
            margin = MARGIN_FACTOR * float(blocks.std(ddof=1)) / sqrt(blocks.size)
            worst = max(worst, (float(blocks.mean()), margin), key=sum)
        return replace(candidate, flip=worst[0], margin=worst[1])

    def _by_povray(self, sheet: str, antialias: str) -> list[Picture]:
        def render(source: str, part: Mosaic) -> Picture:
            size = part.side * len(part.blocks[0]), part.side * len(part.blocks)
            rendering = _MosaicRendering(size=size, antialias=antialias, timeout=self.timeout)
            with temporary_folder() as folder:
                return read_png(runner.run(source, rendering, folder))

        povray.warn_of(piece for scene, _ in self.mosaics for piece in pieces(scene).values())
        runner = povray.Runner(at_once=max(1, min(default_workers(), len(self.mosaics))))
        with thread_pool(runner) as pool:
            # to_pov runs in this thread: it traces rays in Python, and Ctrl-C interrupts only this thread
            texts = [to_pov(scene.model_copy(update={"sheet": sheet}), part) for scene, part in self.mosaics]
            return list(pool.map(render, texts, [part for _, part in self.mosaics]))

    def _by_gl(self, sheet: str, antialias: str) -> list[Picture]:
        runner = gl_runner.Runner()

        def block(scene: AxialScene, corner: Sequence[int], side: int) -> Picture:
            """Draw the part of the scene's picture that begins at this pixel: it is a picture of its own."""
            across, extent = scene.view / self.size[1], side + 2 * EDGE
            x, y = ((start + side / 2 - all_ / 2) * across for start, all_ in zip(corner, self.size, strict=True))
            own = {"look": (scene.middle.real + x, scene.middle.imag - y), "view": extent * across}
            rendering = _MosaicRendering(
                renderer="gl", size=(extent, extent), antialias=antialias, timeout=self.timeout
            )
            source = gl_scene.to_text(scene.model_copy(update=own), shapes, found)
            with temporary_folder() as folder:
                return read_png(runner.run(source, rendering, folder))[EDGE:-EDGE, EDGE:-EDGE]

        mosaics = []
        for scene, part in self.mosaics:
            shown = scene.model_copy(update={"sheet": sheet})
            shapes, found = volumes(pieces(shown), timeout=self.timeout), survey_cache.found(shown)
            rows = [[block(shown, corner, part.side) for corner in row] for row in part.blocks]
            mosaics.append(np.vstack([np.hstack(row) for row in rows]))
        return mosaics


def mosaic(scene: AxialScene, size: tuple[int, int], block_side: int = BLOCK_SIDE) -> Mosaic | None:
    """Return blocks of the window's pixels, or None if no pixel shows the window.

    The places where a block can begin are divided into equal parts. In each part, one block begins at a random place,
    the same one each time. Neighbouring blocks can overlap. `size` is the picture's width and height, in pixels. The
    sides of a block have about `block_side` pixels.
    """
    inside, _ = camera.rays(scene, size)
    if not inside.any():
        return None
    y, x = camera.window(scene, size)
    height, width = y.stop - y.start, x.stop - x.start
    whole = min(float(np.clip(sqrt(MAX_SHARE * height * width), *MOSAIC_SIDES)), height, width)
    count = max(MIN_BLOCKS, round(whole / block_side))
    side = max(1, int(whole / count) // 2 * 2)  # an even number, or 1: if it is even, 1.5 * side is a whole number
    shift = np.random.default_rng(1).uniform(size=(2, count, count))
    rows = y.start + ((np.arange(count)[:, None] + shift[0]) / count * (height - side)).round().astype(int)
    columns = x.start + ((np.arange(count) + shift[1]) / count * (width - side)).round().astype(int)
    return Mosaic(size, side, np.stack((columns, rows), axis=-1).tolist())


def _flip(picture: Picture, converged: Picture, side: int, around: int = 0) -> NDArray[np.float64]:
    """Return the mean FLIP of each block of a mosaic, (rows, columns).

    Each block is first surrounded by copies of itself, `around` pixels wide.
    """
    extent, columns = side + 2 * around, picture.shape[1] // side
    index = np.arange(-around, side + around) % side

    def repeated(mosaic: Picture) -> Picture:
        blocks = mosaic.reshape(-1, side, columns, side, 3)[:, index][:, :, :, index]
        return blocks.reshape(-1, columns * extent, 3)

    off = flip(repeated(picture), repeated(converged)).reshape(-1, extent, columns, extent)
    inner = slice(around, around + side)
    return np.asarray(off[:, inner, :, inner].mean((1, 3)), np.float64)


def _position_error(scene: AxialScene, sheet: str) -> float:
    """Return the greatest error of a point's apparent position, in tiles, if `sheet` replaces the scene's prisms.

    The points appear in all parts of the window. Their distances are those of the scene's objects, and FAR_DISTANCE.
    The result is infinite if eq. 7 is not reliable at one of these distances.
    """
    if sheet == "detailed":
        return 0.0
    alpha = radians(scene.alpha)
    side = np.linspace(-0.45, 0.45, 5) * scene.aperture
    positions = (side + 1j * side[:, None]).ravel()
    worst = 0.0
    for z1 in (*scene.distances, FAR_DISTANCE):
        L = equations.object_position(positions, scene.E, z1, scene.z2, alpha)
        prisms = scene.apparent_position(L, z1)
        if equations.condition(scene.z2 / z1, alpha) > limits.MAX_CONDITION:
            return inf
        shown = positions if sheet == "ideal" else equations.apparent_position(L, scene.E, z1, scene.z2, 0.0)
        worst = max(worst, float(abs(shown - prisms).max()))
    return worst
