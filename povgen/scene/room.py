"""A scene of one's own: objects and windows that stand anywhere."""

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from math import dist
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, SerializeAsAny, model_validator

from povgen.errors import InputError, shown
from povgen.inputs.pictures import File
from povgen.objects import OBJECTS
from povgen.objects.placed import Coordinate, Placed
from povgen.objects.scene_object import SceneObject
from povgen.objects.window import Window
from povgen.optics.camera import Camera
from povgen.optics.opening import Opening
from povgen.scene import checks, files, traced_rays
from povgen.scene.scene import Scene
from povgen.scene.white import WHITE
from povgen.scene.windows import has_glass, several, stated_as, window_table
from povgen.validation import Model

MOST_WINDOWS, MOST_OBJECTS = 20, 100
PLACES = ("x", "y", "z", "look_x", "look_y", "look_z")  # numbers of an eye
# what a room's file can say of a movie: fields of `MovieSpec`
OF_MOVIES = {"title", "frame_rate", "frames", "exact_frames", "ease", "hold", "overlay", "note", "side_view", "loop"}
OF_MOVIES |= {"sweep", "notes"}


class Eye(Model):
    """Where the eye is, where it looks, and how much it sees. The picture is upright unless it is rolled."""

    x: Coordinate = Field(default=0, description="x of the eye, to the right, -10000 to 10000 tiles")
    y: Coordinate = Field(default=0, description="y of the eye, upwards, -10000 to 10000 tiles")
    z: Coordinate = Field(default=-6, description="z of the eye, -10000 to 10000 tiles; it looks along z")
    look_x: Coordinate = Field(default=0, description="x of the point in the picture's middle, tiles")
    look_y: Coordinate = Field(default=0, description="y of the point in the picture's middle, tiles")
    look_z: Coordinate = Field(default=0, description="z of the point in the picture's middle, tiles")
    roll: Annotated[float, Field(ge=-3600, le=3600)] = Field(
        default=0, description="turn of the eye about its line of sight, counter-clockwise as it sees it, degrees"
    )
    view: Annotated[float, Field(ge=0.01, le=1000)] = Field(
        default=5, description="height of the picture at the point in its middle, 0.01 to 1000 tiles"
    )
    aside: Coordinate = Field(
        default=0,
        description="how far the eye is moved along the picture's right side, tiles; the picture's frame stays",
    )
    above: Coordinate = Field(default=0, description="the same along its upper side")

    @model_validator(mode="after")
    def _check(self) -> Self:
        if dist((self.x, self.y, self.z), (self.look_x, self.look_y, self.look_z)) < 1e-6:
            raise ValueError("look_x, look_y, look_z: where the eye is; allowed: another point")
        return self

    @property
    def camera(self) -> Camera:
        """The camera of this eye."""
        place, middle = (self.x, self.y, self.z), (self.look_x, self.look_y, self.look_z)
        along = np.subtract(middle, place)
        along = along / np.linalg.norm(along)
        # an eye that looks straight up or down has its right side along x
        right = np.cross((0, 1, 0), along) if np.hypot(along[0], along[2]) > 1e-9 else np.array([1.0, 0, 0])
        right = right / np.linalg.norm(right)
        up, turn = np.cross(along, right), np.radians(self.roll)
        # a picture whose eye is turned counter-clockwise has its sides turned so
        sides = np.cos(turn) * right + np.sin(turn) * up, np.cos(turn) * up - np.sin(turn) * right
        (rx, ry, rz), (ux, uy, uz) = (side.tolist() for side in sides)
        x, y, z = (np.array(place) + self.aside * sides[0] + self.above * sides[1]).tolist()
        return Camera((x, y, z), middle, (rx, ry, rz), (ux, uy, uz), self.view)


def changed(values: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return a room's values with changes. Text or a table for the eye changes only what it states."""
    eye = values.get("eye")
    try:
        own = {name: getattr(eye, name) for name in eye.model_fields_set} if isinstance(eye, Eye) else eye
        before = window_table(own)
        stated = window_table(changes.get("eye"))
    except ValueError:  # the room refuses it
        stated = None
    if isinstance(stated, Mapping) and isinstance(before, Mapping) and before.keys() - stated.keys():
        return {**values, **changes, "eye": {**before, **stated}}
    return {**values, **changes}


def _object(kind: object = None, **values: Any) -> SceneObject:  # noqa: ANN401
    if not isinstance(kind, str) or kind not in OBJECTS:
        what = "kind: missing;" if kind is None else f"kind = {shown(kind)}:"
        raise InputError(f"{what} allowed: {', '.join(OBJECTS)}")
    return OBJECTS[kind](**values)


if TYPE_CHECKING:  # read as objects; a user may give anything that becomes such a tuple
    Objects = tuple[SceneObject, ...] | Any
    RoomWindows = tuple[Window, ...] | Any
else:
    Objects = several(SerializeAsAny[SceneObject], _object, MOST_OBJECTS)
    RoomWindows = several(Window, Window, MOST_WINDOWS)


class Room(Scene):
    """Objects and windows that stand anywhere: `Room([Window(alpha=90), Piece(z=2)], eye=Eye(z=-6))`."""

    name: ClassVar[str] = "room"
    subject: ClassVar[str] = "a room with windows that bend light"

    object: Objects = Field(default=(), description="an object, such as kind=sphere,x=1,z=2; up to 100")
    window: RoomWindows = Field(default=(), description="a window, such as alpha=90,x=-2,yaw=30; up to 20")
    eye: Annotated[Eye, stated_as(Eye)] = Field(default=Eye(), description="the eye, such as x=1,z=-8,view=4")

    if TYPE_CHECKING:  # the names of values are those of the parameters
        _listed: Placed | Iterable[Placed] = Field(default=(), kw_only=False)

        @property
        def replace(self) -> type[Self]: ...
    else:

        def __init__(self, things: Placed | Iterable[Placed] = (), /, **values: Any) -> None:  # noqa: ANN401
            """Make a room of objects and windows, or of the lists `object` and `window`."""
            if not isinstance(things, (Placed, Iterable)):
                raise InputError(f"things = {shown(things)}: allowed: a list of objects and windows")
            for thing in [things] if isinstance(things, Placed) else things:
                name = "window" if isinstance(thing, Window) else "object"
                given = values.get(name, ())
                values[name] = [*(given if isinstance(given, (list, tuple)) else [given]), thing]
            super().__init__(**values)

    @cached_property
    def things(self) -> dict[str, Placed]:
        """All objects and windows, by their names. One without a name has its kind's name and a number."""
        return dict(zip(self._names, (*self.window, *self.object), strict=True))

    @property
    def _names(self) -> list[str]:
        kinds = [*["window"] * len(self.window), *(thing.kind for thing in self.object)]
        named = zip((*self.window, *self.object), kinds, strict=True)
        return [thing.name or f"{kind}{kinds[: n + 1].count(kind)}" for n, (thing, kind) in enumerate(named)]

    @classmethod
    def load(cls, path: str | Path, **values: Any) -> Self:  # noqa: ANN401
        """Read a room from a TOML file, or from standard input (-): tables [eye], [[window]] and [[object]].

        The other parameters stand above these tables. Paths of files are relative to the TOML file's folder; a warning
        names those that are outside of it. What the file says of a movie is not read. `values` replace the file's;
        text or a table for the eye changes only what it states. Raises InputError, which names the file.
        """
        text, name, folder = files.text_of(
            path, "room", "a TOML file with tables [eye], [[window]] and [[object]], or --from a picture"
        )
        table = {key: value for key, value in files.table_of(text, name).items() if key not in OF_MOVIES}
        try:
            if not table:
                raise InputError("states nothing; allowed: a room's tables, such as [[window]] and [[object]]")
            if (scene := table.pop("scene", cls.name)) != cls.name:
                raise InputError(f"scene = {shown(scene)}: no room; allowed: a room's tables, or a movie of this file")
            stated = changed(files.in_folder(table, folder), values)
            made = cls(**stated)
        except InputError as error:
            raise InputError(f"{name}: {error}") from None
        files.name_files_outside(folder, name, tuple(getattr(made, key) for key in stated if key not in values))
        return made

    @property
    def parts(self) -> Mapping[str, Model]:
        return {**self.things, "eye": self.eye}

    def with_numbers(self, values: Mapping[str, float]) -> Self:
        parts = dict(self.parts)
        for name, value in values.items():
            part, _, parameter = name.partition(".")
            if part not in parts or not parameter:
                allowed = f"NAME.PARAMETER with one of {', '.join(parts)}"
                raise InputError(f"{shown(name)}: not in the room; allowed: {allowed}")
            parts[part] = parts[part].replace(**{parameter: value})
        eye, things = parts.pop("eye"), [*parts.values()]
        return self.replace(eye=eye, window=things[: len(self.window)], object=things[len(self.window) :])

    def seen_from(self, aside: complex, moved: complex = 0) -> Self:
        eye, camera = self.eye, self.camera
        # the eye and the point in the picture's middle go together, so that the picture's sides do not turn
        step = moved.real * np.array(camera.right) + moved.imag * np.array(camera.up)
        places = {name: round(getattr(eye, name) + step[k % 3], 12) for k, name in enumerate(PLACES)}
        way = aside - moved
        sides = {"aside": round(eye.aside + way.real, 12), "above": round(eye.above + way.imag, 12)}
        return self.replace(eye=eye.replace(**places, **sides))

    def _replaced_by(self, changes: dict[str, Any]) -> set[str]:
        changes.update(changed({"eye": self.eye}, changes) if "eye" in changes else {})
        return set()

    @property
    def camera(self) -> Camera:
        return self.eye.camera

    def fitted(self, size: tuple[int, int]) -> Self:
        """Return the room with its default view: in a narrow picture, as wide as it is high in others."""
        if "view" in self.eye.model_fields_set or (shape := size[0] / size[1]) >= 1:
            return self
        return self.replace(eye=self.eye.replace(view=self.eye.view / shape))

    @cached_property
    def openings(self) -> Sequence[Opening]:
        return [window.opening for window in self.window]

    @cached_property
    def rays_file(self) -> File | None:
        """The file of the rays with which POV-Ray shows ideal windows; None without such windows."""
        return traced_rays.file(self.openings, self.camera, self.tile)

    @property
    def named_openings(self) -> dict[str, Opening]:
        return dict(zip(self.things, self.openings, strict=False))  # windows come first

    def ray_tables(self, size: tuple[int, int]) -> Iterable[bytes]:
        """Return the tables of rays that the room's text for POV-Ray reads: none without ideal windows."""
        if self.rays_file is None:
            return ()
        rays = traced_rays.of_file(self.rays_file.content)
        return traced_rays.Found.of(rays, size).legs(rays.tile)

    @property
    def contents(self) -> Sequence[SceneObject]:
        return self.object

    @model_validator(mode="after")
    def _check_room(self) -> Self:
        if "eye" in self._names:
            raise ValueError("name = 'eye': the eye has it; allowed: another name")
        small = [name.lower() for name in self._names]  # texts for POV-Ray begin all names with a capital letter
        if twice := [name for name, own in zip(self._names, small, strict=True) if small.count(own) > 1]:
            raise ValueError(
                f"name = {shown(twice[-1])}: two things have it; allowed: different names, also in small letters"
            )
        # the model is frozen
        object.__setattr__(self, "window", tuple(checks.with_index(each, self.wavelength) for each in self.window))
        if self.wavelength == WHITE and not any(map(has_glass, self.window)):
            raise ValueError(checks.for_no_glass("wavelength", WHITE))
        if self.fresnel and self.has_prisms and self.rays_file:
            raise ValueError(
                "fresnel = true: not with ideal sheets in the room, where rays would split; allowed: false"
            )
        checks.check_apart(self.things, self.camera.eye)
        return self
