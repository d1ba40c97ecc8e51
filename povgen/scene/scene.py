"""What every scene has: an eye, windows, objects, light and a background. A scene never changes. Variants are copies.

Lengths are in tiles (the side of a floor tile), angles in degrees. x points right, y up and z away from the eye.
"""

from __future__ import annotations  # help() then says ArrayLike

import time
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from importlib import import_module
from itertools import islice
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike
from pydantic import BeforeValidator, Field

from povgen import limits
from povgen.errors import InputError, input_errors, one_line, shown
from povgen.inputs import pictures
from povgen.inputs.fields import PictureFile, PictureSize
from povgen.objects.scene_object import SceneObject
from povgen.objects.window import RIM
from povgen.optics.camera import Camera
from povgen.optics.equations import real
from povgen.optics.opening import Opening
from povgen.optics.paths import Image, Paths
from povgen.optics.rays import AT_ONCE, Bundle, Traced
from povgen.optics.trace import End
from povgen.optics.window_trace import trace_windows
from povgen.record import Record, in_use, info
from povgen.sheets.layered import Layered
from povgen.sheets.parameters import WAVELENGTH
from povgen.sheets.sheet import Sheet
from povgen.validation import Model, as_flag

PATIENCE = 120  # CPU seconds in which a record's frames are checked; 10,000 frames of a window of prisms take 4


class Scene(Model):
    """What all scenes share: light and background, and what follows from eye, windows and objects."""

    name: ClassVar[str]
    subject: ClassVar[str]
    in_turn: ClassVar[bool] = False  # whether light is to pass every window, one after another
    rim: ClassVar[float] = RIM  # width of a window frame's sides, tiles

    wavelength: Annotated[float, Field(ge=180, le=10000)] | Literal["white"] = Field(
        default=WAVELENGTH,
        description="wavelength of light, for the index of a glass, 180 to 10000 nm; the picture's colours do not "
        "change; white: a picture of all colours, each with its own index",
    )
    fresnel: bool = Field(
        default=False, description="partial reflection at every face of the prisms; takes 4 to 13 times as long"
    )
    background: Literal["sky", "transparent", "black", "white"] = Field(
        default="sky", description="what is behind the scene: sky, transparent (PNG only), black or white"
    )
    sky: Annotated[PictureFile | None, BeforeValidator(pictures.sky)] = Field(
        default=None,
        description="mountains (povgen's own), or a picture of the surroundings: a PNG, JPEG, WebP, TIFF, HDR or EXR "
        "file, equirectangular, whose middle is straight ahead; with background = sky",
    )
    pupil: Annotated[float, Field(ge=0, le=5)] = Field(
        default=0,
        description="diameter of the eye's pupil, up to 5 tiles; 0: a pinhole, for which all is sharp",
    )
    focus: Annotated[float, Field(gt=0, le=1e6)] | Literal["best"] = Field(
        default="best",
        description="distance of the eye's focus, up to 1e6 tiles; best: that which blurs the first object least",
    )

    @classmethod
    def from_file(cls, path: object) -> Self:
        """Return the scene of a picture's file, with every parameter. It has the class that the file states.

        Raises InputError for a file that povgen did not write, for a movie, and for a scene of another class.
        """
        first, *others = cls.list_from_file(path)
        if others:
            raise InputError(
                f"{str(path)!r}: a movie of {len(others) + 1} frames; allowed: a picture, or list_from_file"
            )
        return first

    @classmethod
    def list_from_file(cls, path: object) -> list[Self]:
        """Return the scene of every frame of a movie's file, or the one of a picture's file, with every parameter.

        Raises InputError for a file that povgen did not write, and for scenes of another class.
        """
        _, scenes = recorded(path, cls)
        return scenes

    @property
    def camera(self) -> Camera:
        """The eye, and the rectangle that the picture shows."""
        raise NotImplementedError

    def fitted(self, size: tuple[int, int]) -> Self:
        """Return the scene with its default view for a picture of this size. A view that is stated stays."""
        raise NotImplementedError

    @property
    def openings(self) -> Sequence[Opening]:
        """The windows as in `optics.opening`, with the sheet in each."""
        raise NotImplementedError

    @property
    def contents(self) -> Sequence[SceneObject]:
        """The objects, the floor among them."""
        return ()

    @property
    def parts(self) -> Mapping[str, Model]:
        """What has numbers of its own, by the names in a movie's sweeps: windows, objects and eye of a room."""
        return {}

    def with_numbers(self, values: Mapping[str, float]) -> Self:
        """Return a copy with other numbers of its `parts`, as {"left.alpha": 90, "eye.x": 1}. Raises InputError.

        A preset takes values of its fields, of their components and of windows behind the first one, as {"alpha": 90,
        "eye_x": 1, "window2_alpha": 90}.
        """
        raise NotImplementedError

    @property
    def middle(self) -> complex:
        """The picture's middle, as positions in its plane are counted: 0, but for a preset that looks elsewhere."""
        return 0

    def seen_from(self, aside: complex, moved: complex = 0) -> Self:
        """Return the scene for an eye that is moved `aside` along the picture's sides: x + iy, tiles.

        The rectangle that the picture shows is `moved`, tiles. Raises InputError if the eye cannot be there.
        """
        raise NotImplementedError

    @property
    def outlines(self) -> tuple[str, ...]:
        """The names of the parameters that draw an outline on the picture, and are true."""
        return ()

    @property
    def sheets(self) -> tuple[Sheet, ...]:
        """The sheet in each window, in the order of `openings`."""
        return tuple(opening.sheet for opening in self.openings)  # type: ignore[misc]  # an Element is a Sheet here

    @property
    def layered(self) -> tuple[Layered, ...]:
        """The sheets of prisms or lenses, in the order of `openings`."""
        return tuple(sheet for sheet in self.sheets if isinstance(sheet, Layered))

    @property
    def has_prisms(self) -> bool:
        """Whether the sheets of a window consist of prisms, or of lenses."""
        return bool(self.layered)

    @property
    def polarised(self) -> bool:
        """Whether there is a polariser or an analyser."""
        return False

    @property
    def named_openings(self) -> dict[str, Opening]:
        """The windows by their names: window1, window2, ..., where they have no own ones."""
        return {f"window{n}": opening for n, opening in enumerate(self.openings, 1)}

    @input_errors()
    def images(self, point: ArrayLike) -> list[Image]:
        """Return where the eye sees a point (x, y, z), tiles, through any windows and beside them: `optics.paths`.

        There is an image for each path of the point's light, with its `position` in the picture's plane (x + iy from
        the picture's middle, along its sides, tiles) and the names of the `windows` on the path, the nearest to the eye
        first. The image nearest to the picture's middle comes first. If no light reaches the eye, the list is empty.
        Objects hide nothing. Raises InputError for what is no point.
        """
        place = real("point", point)
        if place.shape != (3,) or not np.isfinite(place).all():
            raise ValueError(f"point = {shown(point)}: allowed: x, y and z, in tiles")
        return paths(self).images(place)[0]

    @property
    def tile(self) -> int:
        """POV-Ray's units per tile."""
        return limits.units_per_tile(min((sheet.pitch for sheet in self.layered), default=1))

    @input_errors()
    def rays(self, size: str | Sequence[int]) -> Bundle:
        """Return a ray from the eye for each pixel of a picture: `size` is its width and height, or text as '64x48'.

        The rays' positions, in tiles, and their unit directions are arrays (height, width, 3). The first row is the top
        one. They are those of `render` with this size. Raises InputError for a width or a height that is not a whole
        number from 1 to MAX_SIDE, and for more than 40 million pixels.
        """
        width, height = PictureSize(size=size).size
        if width * height > AT_ONCE:
            raise InputError(f"size = {width}x{height}: allowed: up to {AT_ONCE} rays at once")
        return self.fitted((width, height)).camera.rays((width, height))

    @input_errors()
    def trace(
        self,
        rays: Bundle,
        max_faces: int = 60,
        partial: Generator | None = None,
        path: bool = False,
        device: Literal["numpy", "gl"] = "numpy",
    ) -> Traced:
        """Follow rays through the windows, exactly: through prisms and ideal sheets.

        Objects do not stop them, but the windows' frames do. Positions are in tiles. A ray ends after it has met
        `max_faces` faces of prisms or lenses. Where windows stand one behind the other (`Chess`, `Spheres`), rays that
        do not pass every window end as `End.BESIDE`. If `partial`, a generator of random numbers, is given, a face that
        refracts light also reflects a part of it (`optics.trace`). Otherwise reflection is only total. With `path`, the
        result has the rays' whole paths: their `corners`, optical `length`, `jones` matrices and a `table`. With
        `device="gl"`, the graphics library follows rays through prisms and lenses, with numbers of 32 bits: for at most
        1000 steps from face to face in a window, and `faces` is empty. Raises InputError for a ray that starts inside a
        window's sheets, for a `max_faces` that is not a whole number from 1 to 100,000, and for what gl does not do:
        `partial`, `path`, and sheets of unequal prisms or lenses.
        """
        if device not in ("numpy", "gl"):
            raise ValueError(f"device = {shown(device)}: allowed: 'numpy' or 'gl'")
        if device == "gl" and (partial is not None or path):
            raise ValueError("device = 'gl': keeps no path, and splits no rays; allowed: without partial and path")
        # not imported above: scenes do not depend on rendering
        follow = import_module("povgen.rendering.gl_rays").follow if device == "gl" else None
        openings = self.openings
        found = trace_windows(rays, openings, max_faces, partial, as_flag("path", path), follow)
        if self.in_turn:
            passed = found.met_each_in_turn(rays.direction[..., 2] > 0, len(openings))
            found.end[(found.end <= End.BACK) & ~passed] = End.BESIDE
            found.designed &= found.end == End.THROUGH
        return found


@lru_cache(maxsize=4)  # they need up to 16 MB
def paths(scene: Scene) -> Paths:
    """Return the paths of light to a scene's eye."""
    return Paths(scene.camera, scene.named_openings)


@lru_cache(maxsize=4096)  # caption, legend and overlay need them
def object_images(scene: Scene) -> list[tuple[SceneObject, list[Image]]]:
    """Return the objects that have a point (`SceneObject.point`), and the images of each one's."""
    points = [(each, point) for each in scene.contents if (point := each.point) is not None]
    return [*zip((each for each, _ in points), paths(scene).images([point for _, point in points]), strict=True)]


SCENES: dict[str, type[Scene]] = {}  # the classes of scenes, by their names


def classes(kind: type[Scene] = Scene) -> str:
    """Return povgen's classes of scenes of this kind, for a message."""
    return " or ".join(f"{each.__name__}(...)" for each in SCENES.values() if issubclass(each, kind))


def checked_scene(scene: object) -> Scene:
    """Return the scene. Raises InputError if it is none."""
    if not isinstance(scene, Scene) or not hasattr(scene, "name"):  # `Scene` itself has no name
        raise InputError(f"scene = {shown(scene)}: should be a scene; allowed: {classes()}")
    return scene


def checked_class(scene: Scene, what: str) -> None:
    """Raise InputError if the scene is not of povgen's own classes, which are all that `what` knows."""
    if type(scene) not in SCENES.values():
        raise InputError(f"scene = {shown(scene)}: {what} does not know this class; allowed: {classes()}")


def is_empty(scene: Scene) -> bool:
    """Return whether no window has a sheet."""
    return {sheet.name for sheet in scene.sheets} <= {"none"}


def checked_scenes(scenes: Iterable[object], most: int) -> list[Scene]:
    """Return the scenes as a list. Raises InputError for more than `most`, as of an endless generator, or for no scene.

    An empty list is allowed.
    """
    found = [checked_scene(scene) for scene in islice(scenes, most + 1)]
    if len(found) > most:
        raise InputError(f"more than {most} scenes; allowed: up to {most}")
    return found


def recorded(path: Any, kind: type[Scene] = Scene) -> tuple[Record, list[Any]]:  # noqa: ANN401  (any object)
    """Return the record in a file that povgen wrote, and the scene of every frame, of this class. Raises InputError."""
    record = info(path)
    if not record.frames:
        raise InputError(f"{str(path)!r}: its record has no scene; allowed: a picture or a movie")
    try:
        return record, of_record(record, kind)
    except InputError as error:
        raise InputError(f"{str(path)!r}: its record, of povgen {one_line(record.povgen)[:20]}: {error}") from None


def of_record(record: Record, kind: type[Scene] = Scene) -> list[Scene]:
    """Return the scene of every frame of a record, of this class. Raises InputError.

    The record can be a stranger's: every value is checked, and no file is read.
    """
    known = {**SCENES, **({kind.name: kind} if hasattr(kind, "name") else {})}
    known = {name: scene for name, scene in known.items() if issubclass(scene, kind)}
    made: list[Scene] = []
    end = time.process_time() + PATIENCE
    with in_use(record):
        for values in record.values:
            if time.process_time() > end:
                count = f"{len(made)} of {len(record.frames)} were checked within {PATIENCE} s"
                raise InputError(f"frames: {count}; allowed: frames that take less time")
            name, windows = values.get("scene"), values.get("window", [])
            if not isinstance(name, str) or name not in known:
                raise InputError(f"scene = {shown(name)}: allowed: {', '.join(known)}")
            if not (isinstance(windows, list) and all(isinstance(window, dict) for window in windows)):
                raise InputError(f"window = {shown(windows)}: should be a list of tables")
            own = {key: value for key, value in values.items() if key != "scene"}
            made.append(known[name](**_without_index(own | {"window": [*map(_without_index, windows)]})))
    return made


def _without_index(window: dict[str, Any]) -> dict[str, Any]:
    """Return the values of a scene or of a window without the index if a glass is named: it follows from the glass."""
    named = window.get("glass") not in (None, "none")
    return {name: value for name, value in window.items() if not (named and name == "index")}
