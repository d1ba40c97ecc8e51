"""The cost and the error of pictures of a scene: `povgen chart` measures every renderer with several samplings.

The cost is CPU seconds. The error is the difference, inside the window, from a converged picture.
"""

import platform
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from statistics import median

import numpy as np

from povgen.errors import InputError
from povgen.files import temporary_folder
from povgen.measure.measured import rms
from povgen.measure.opengl import OpenGLView
from povgen.measure.probes import Size
from povgen.rendering import gl_runner, parallel, povray
from povgen.rendering.flip import CONVERGED, flip
from povgen.rendering.frames import read_png
from povgen.rendering.light import Picture
from povgen.rendering.parallel import cpu_seconds
from povgen.scene import camera
from povgen.scene.presets import AxialScene
from povgen.scene.sdl import to_pov
from povgen.settings import Rendering

SIZES = ((160, 120), (320, 240), (640, 480))
SAMPLINGS = (
    *("off", "1,0.9,2", "1,0.3,2", "1,0.1,2", "1,0.9,3", "1,0.3,3", "1,0.1,3", "1,0.3,4", "1,0.1,4"),
    *("2,0.9,1", "2,0.3,1", "2,0.9,2", "2,0.3,2", "2,0.1,2", "2,0.3,3", "2,0.1,3", "1.5x", "2x", "3x", "4x"),
)
# the renderer gl draws the same number of rays in every pixel: METHOD and THRESHOLD of POV-Ray do not matter
GL_SAMPLINGS = ("off", "2x", "3x", "4x", "1,0.1,2", "1,0.1,3", "1,0.1,4", "1,0.1,8")
ROUNDS = 5


@dataclass
class Point:
    """A way to make a picture, its CPU seconds, and the picture's error."""

    method: str  # the model of the sheets, alone (by POV-Ray) or after 'gl '; or what else made the picture
    sampling: str
    size: Size
    make: Callable[[], tuple[float, Picture]] = field(repr=False)  # makes the picture: returns CPU seconds and picture
    seconds: list[float] = field(default_factory=list, repr=False)
    picture: Picture = field(init=False, repr=False)
    rms: float = np.nan
    flip: float = np.nan

    @property
    def row(self) -> tuple[object, ...]:
        """The point's row in the table: method, sampling, width, height, median CPU seconds, RMS, FLIP."""
        numbers = (f"{x:.4g}" for x in (median(self.seconds), self.rms, self.flip))
        return self.method, self.sampling, *self.size, *numbers


def machine() -> str:
    """Describe this machine in one line."""
    cores = parallel.cores()
    return f"{platform.machine()}, {cores} cores, POV-Ray {povray.version()}, Python {platform.python_version()}"


def sample(text: str, sampling: str, size: Size) -> tuple[float, Picture]:
    """Render a scene's text by POV-Ray. Return the CPU seconds of POV-Ray and of povgen, and the picture.

    Raises PovrayError if POV-Ray fails.

    No other child process is allowed to end during the call, and no other thread to work: their CPU seconds would be
    counted too.
    """
    with temporary_folder() as folder:
        before = cpu_seconds()
        path = povray.run(text, Rendering(size=size, antialias=sampling), folder)
        return cpu_seconds() - before, read_png(path)


def drawn_sample(view: OpenGLView, sampling: str, size: Size) -> tuple[float, Picture]:
    """Return the CPU seconds that the renderer gl uses for a picture, in all threads, and the picture.

    If the scene has been drawn before, this does not include the time to start OpenGL and to compile the shaders.
    """
    with temporary_folder() as folder:
        before, runner = cpu_seconds(), gl_runner.Runner()
        rendering = Rendering(renderer="gl", size=size, antialias=sampling)
        picture = read_png(runner.run(view.source(), rendering, folder))
        return cpu_seconds() - before + runner.cpu_seconds[-1], picture


def picture_error(picture: Picture, reference: Picture, scene: AxialScene) -> tuple[float, float]:
    """Return the RMS difference (0 to 1) and the mean FLIP of two pictures, inside the window."""
    height, width = reference.shape[:2]
    window = camera.window(scene, (width, height))
    a, b = (image[window].astype(float) / 255 for image in (reference, picture))
    return rms(a - b), float(flip(picture[window], reference[window]).mean())


def measure_samplings(
    scenes: Mapping[str, AxialScene], done: Callable[[str], object], others: Sequence[Point] = ()
) -> list[Point]:
    """Measure the scenes, by their methods' names, with every renderer and sampling, and then the points `others`.

    The others' method has a converged picture if it is one of the scenes'; else that of the first scene counts.
    Calls `done` with the name of each finished step. If OpenGL is missing, `done` is told so, and the renderer gl is
    not measured.
    """
    texts = {method: to_pov(scene) for method, scene in scenes.items()}
    points = [
        Point(method, sampling, size, partial(sample, text, sampling, size))
        for (method, text), size, sampling in product(texts.items(), SIZES, SAMPLINGS)
    ] + [*others]
    try:
        points += _gl_points(scenes)
    except InputError as error:
        done(f"without the renderer gl: {error}")
    for number in range(ROUNDS):
        for point in points:
            # only one round for the largest size: its frames take long, and their times vary little
            if number == 0 or point.size != SIZES[-1]:
                seconds, point.picture = point.make()
                point.seconds.append(seconds)
        done(f"frames, round {number + 1} of {ROUNDS}")
    for size, (method, text) in product(SIZES, texts.items()):
        converged = sample(text, CONVERGED, size)[1]
        for point in points:
            own = next((name for name in texts if name in point.method.split()), next(iter(texts)))
            if (point.size, own) == (size, method):
                point.rms, point.flip = picture_error(point.picture, converged, scenes[method])
        done(f"converged pictures of {size[0]}x{size[1]}, {method}")
    return points


def _gl_points(scenes: Mapping[str, AxialScene]) -> Iterator[Point]:
    """Return the points of the renderer gl. Raises InputError without OpenGL."""
    views = {method: OpenGLView(scene) for method, scene in scenes.items()}
    for (method, view), size, sampling in product(views.items(), SIZES, GL_SAMPLINGS):
        view.picture(SIZES[0], 1)  # the first picture compiles the shaders
        yield Point(f"gl {method}", sampling, size, partial(drawn_sample, view, sampling, size))
