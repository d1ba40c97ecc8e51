"""Draw pictures with the graphics library OpenGL, by the live view's shaders. No other module calls OpenGL.

`gl_runner` starts this module as a process, so that a graphics driver that crashes ends only this process. At its start
the process writes a line of JSON: the device's name and OpenGL's version, or an `error`. Then it reads a line of JSON
for each picture. While it draws, it writes lines with each further `part` of the picture, a fraction. At the end of the
picture it writes an empty object, or an `error`. Its `errno` is not null if the system gave one.
"""

import json
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from io import BytesIO
from itertools import product
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray
from PIL.Image import fromarray
from PIL.JpegImagePlugin import JpegImageFile
from PIL.PngImagePlugin import PngImageFile

from povgen import stopping
from povgen.inputs import hdr
from povgen.rendering.light import packed, place
from povgen.rendering.volumes import decoded

# A picture is drawn in squares, so that it may be of any size. In this module, a tile is such a square, not a length.
TILE = 1024  # pixels, a power of 2: the side of such a square
PROGRAMS = 30  # at most so many compiled programs are kept: each law of a user's own needs another one
RUN_LENGTHS = 3  # Z_RLE of zlib: it compresses only runs of equal bytes
SRGB8 = 0x8C41  # OpenGL's number: colours of 8 bits, which become linear light before they are interpolated
VERTICES = """#version 330
void main() { gl_Position = vec4(4 * (gl_VertexID & 1) - 1, 2 * (gl_VertexID & 2) - 1, 0, 1); }"""
SPARE = 1 << 28  # bytes, of which a driver needs a part when it starts


class Drawer:
    """An OpenGL context, and the programs and distance fields that it knows."""

    def __init__(self) -> None:
        """Make a context without a window. Raises a plain Exception, no subclass, if the system has no OpenGL 3.3."""
        backend: dict[str, Any] = {"backend": "egl"} if sys.platform == "linux" else {}
        self.gl = moderngl.create_context(standalone=True, require=330, **backend)
        self.gl.gc_mode = "context_gc"  # `gc` frees what Python no longer refers to
        self.device = self.gl.info["GL_RENDERER"]
        self.version = self.gl.info["GL_VERSION"]
        self.programs: dict[str, Any] = {}  # vertex arrays, each with its program
        self.fields: dict[str, Any] = {}
        self.pictures: dict[tuple[str, bytes], Any] = {}
        # rays: the light of one ray for each pixel of a tile and of a border one pixel wide
        # sum: that of all rays; shown: the sum as bytes
        self.rays, self.sum, self.shown = (
            self.gl.framebuffer([self.gl.texture((side, side), 4, dtype=kind)])
            for side, kind in ((TILE + 2, "f4"), (TILE, "f4"), (TILE, "f1"))
        )
        # the bytes or the light of two tiles: one is read while the other is drawn
        self.buffers = [self.gl.buffer(reserve=12 * TILE * TILE) for _ in range(2)]
        self.sum.clear()
        self.gl.blend_func = moderngl.ONE, moderngl.ONE

    def picture(
        self,
        scene: dict[str, Any],
        size: tuple[int, int],
        rays: int,
        wide_filter: bool = False,
        part: float = 1,
        is_light: bool = False,
        told: Callable[[float], None] = lambda _: None,
    ) -> NDArray[Any]:
        """Return the picture, (height, width, 3), the top row first, with `rays` rays a pixel.

        It is sRGB bytes, or if `is_light`, light as numbers of 32 bits, where 1 is white. `scene` is what
        `gl_scene.to_text` wrote, decoded, with bytes of files in place of their names. `size` is width and height.
        A pixel shows the mean of its own rays, or with the wide filter the weighted mean of the rays nearer than one
        pixel (`light.reduced`). A pixel's rays are in a square around its centre, whose side is `part` pixels. After
        each tile, `told` is called with the tile's fraction of the picture.
        """
        rays_of, share, display = self._prepared(scene, "shader", "share", "display")
        set_uniforms(rays_of, {**scene["uniforms"], "size": size, "first": True, "sum": 0})
        set_uniforms(share, {"picture": 0})
        set_uniforms(display, {"size": (TILE, TILE), "canvas": (TILE, TILE), "rays": rays, "sum": 0})
        width, height = size
        sides = range(0, height, TILE), range(0, width, TILE)
        tiles = [(top, left, min(TILE, height - top), min(TILE, width - left)) for top, left in product(*sides)]
        made = np.empty((height, width, 3), np.float32 if is_light else np.uint8)
        for number, tile in enumerate([*tiles, None]):
            if tile:
                top, left, high, wide = tile
                self.sum.clear(viewport=(0, 0, wide, high))
                for ray in range(rays):
                    x, y = (part * u for u in place(ray, rays, wide_filter))
                    lower_left = x + left - 1, y + height - top - high - 1
                    set_uniforms(rays_of, {"jitter": lower_left, "rayNumber": ray})
                    self._draw(rays_of, self.rays, (wide + 2, high + 2))
                    set_uniforms(share, {"jitter": (x, y) if wide_filter else (0, 0)})
                    self.gl.enable(moderngl.BLEND)
                    self._draw(share, self.sum, (wide, high), self.rays)
                    self.gl.disable(moderngl.BLEND)
                if is_light:
                    self.sum.read_into(self.buffers[number % 2], (0, 0, wide, high), 3, alignment=1, dtype="f4")
                else:
                    self._draw(display, self.shown, (wide, high), self.sum)
                    self.shown.read_into(self.buffers[number % 2], (0, 0, wide, high), 3, alignment=1)
            if number:  # this waits for the tile before, while a graphics processor draws the next
                top, left, high, wide = tiles[number - 1]
                pixels = self.buffers[(number - 1) % 2].read(made.itemsize * 3 * wide * high)
                shown = np.frombuffer(pixels, made.dtype).reshape(high, wide, 3)
                made[top : top + high, left : left + wide] = shown[::-1]
                told(wide * high / (width * height))
        if is_light:
            made /= made.dtype.type(rays)
        return made

    def readout(self, scene: dict[str, Any], size: tuple[int, int]) -> NDArray[np.float32]:
        """Return ray, shown and met, (3, height, width, 4): povgen/liveview/readout.glsl describes them."""
        (program,) = self._prepared(scene, "shader")
        set_uniforms(program, {**scene["uniforms"], "size": size, "jitter": (0, 0), "rayNumber": 0})
        return self._numbers(program, size)[:, ::-1]

    def followed(self, scene: dict[str, Any], rays: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return where rays (2, n, 4) leave a window, (3, n, 4): povgen/liveview/rays.glsl describes both."""
        (program,) = self._prepared(scene, "shader")
        set_uniforms(program, scene["uniforms"])
        count, size = rays.shape[1], (TILE, -(-rays.shape[1] // TILE))
        filled = np.pad(rays, ((0, 0), (0, size[0] * size[1] - count), (0, 0)), "edge")
        given = [self.gl.texture(size, 4, each.tobytes(), dtype="f4") for each in filled]
        for unit, texture in enumerate(given):
            texture.use(unit)
        return self._numbers(program, size).reshape(3, -1, 4)[:, :count]

    def _numbers(self, program: Any, size: tuple[int, int]) -> NDArray[np.float32]:  # noqa: ANN401
        """Return the three results of a program, (3, height, width, 4), the bottom row first."""
        numbers = self.gl.framebuffer([self.gl.texture(size, 4, dtype="f4") for _ in range(3)])
        self._draw(program, numbers, size)
        read = b"".join(numbers.read(components=4, attachment=k, dtype="f4") for k in range(3))
        self.sum.use()  # the context refers to the framebuffer that was used last
        del numbers
        self.gl.gc()
        return np.frombuffer(read, "<f4").reshape(3, size[1], size[0], 4)

    def _draw(self, program: Any, target: Any, size: tuple[int, int], source: Any = None) -> None:  # noqa: ANN401
        """Run a program for the lower left pixels of a framebuffer. It reads the framebuffer `source`."""
        target.viewport = 0, 0, *size
        target.use()
        if source:
            source.color_attachments[0].use(0)
        program.render(moderngl.TRIANGLES, vertices=3)

    def _prepared(self, scene: dict[str, Any], *names: str) -> list[Any]:
        """Return the programs whose texts have these names in a scene. Put what the scene shows into textures."""
        programs = [self._program(scene[name]) for name in names]
        while len(self.programs) > PROGRAMS:
            del self.programs[next(iter(self.programs))]
        self._volumes(scene)
        self._pictures(scene["pictures"])
        self.gl.gc()
        return programs

    def _program(self, text: str) -> Any:  # noqa: ANN401  (moderngl's)
        found = self.programs.pop(text, None)
        if found is None:
            program = self.gl.program(vertex_shader=VERTICES, fragment_shader=f"#version 330\n{text}")
            found = self.gl.vertex_array(program, [])
        self.programs[text] = found  # the last one: it is removed after all others
        return found

    def _volumes(self, scene: dict[str, Any]) -> None:
        """Put the distance fields into a texture: three a row along x, the rows along z."""
        if not scene["volumes"]:
            return
        key = "\0".join(volume["data"] for volume in scene["volumes"])
        if key not in self.fields:
            nx, ny, nz = scene["grid"]
            count = len(scene["volumes"])
            all_ = np.zeros((-(-count // 3) * nz, ny, min(count, 3) * nx), np.float16)
            for k, volume in enumerate(scene["volumes"]):
                at = nz * (k // 3), nx * (k % 3)
                all_[at[0] : at[0] + nz, :, at[1] : at[1] + nx] = field(volume, (nx, ny, nz))
            texture = self.gl.texture3d(all_.shape[::-1], 1, all_.tobytes(), alignment=1, dtype="f2")
            texture.repeat_x = texture.repeat_y = texture.repeat_z = False
            texture.filter = moderngl.LINEAR, moderngl.LINEAR
            self.fields = {key: texture}
        self.fields[key].use(1)

    def _pictures(self, files: dict[str, bytes]) -> None:
        """Put the pictures of sky, floor and boards, and the mountains, into textures."""
        self.pictures = {key: texture for key, texture in self.pictures.items() if key in files.items()}
        for key in files.items():
            if key not in self.pictures:
                texture = self._texture(key[1])
                texture.repeat_x, texture.repeat_y = True, key[0] == "floor"
                self.pictures[key] = texture
            self.pictures[key].use({"sky": 2, "floor": 3, "cards": 4, "mountains": 5}[key[0]])

    def _texture(self, file: bytes) -> Any:  # noqa: ANN401  (moderngl's)
        if file.startswith(hdr.MARK):
            light = hdr.read(file).astype(np.float16)
            return self.gl.texture(light.shape[1::-1], 3, light.tobytes(), alignment=1, dtype="f2")
        kind = JpegImageFile if file.startswith(b"\xff\xd8") else PngImageFile
        with kind(BytesIO(file)) as image:
            return self.gl.texture(image.size, 3, image.tobytes(), alignment=1, internal_format=SRGB8)


def set_uniforms(program: Any, values: dict[str, Any]) -> None:  # noqa: ANN401  (moderngl's)
    """Set those uniforms of a vertex array's program that `values` contains."""
    for name in program.program:
        if name in values:
            uniform, numbers = program.program[name], np.ravel(values[name])
            uniform.write(numbers.astype("i4" if uniform.fmt[-1] == "i" else "f4").tobytes())


def field(volume: dict[str, Any], grid: Sequence[int]) -> NDArray[np.float64]:
    """Return the distances to a piece's surface, (z, y, x), in voxels, below 0 inside, as pieceShape.js does.

    `volume` has the fields of `volumes.Volume`. `grid` is the number of points along x, y and z. The script is
    povgen/liveview/pieceShape.js.
    """
    stored, most = decoded(volume["data"], grid), volume["most"]
    return extend(np.where(stored == 255, np.inf, (stored.astype(float) - 128) / 127 * most), most)


def extend(distance: NDArray[np.float64], most: float) -> NDArray[np.float64]:
    """Return distances (z, y, x), in voxels, also where the given ones are `most` or more, which means unknown.

    There the result is the least sum of a known distance and the way to it along the axes, divided by sqrt(3). It is
    about 0.6 to 1 times the distance.
    """
    found = distance
    for axis, size in enumerate(distance.shape):
        line, along = np.moveaxis(found, axis, -1), np.arange(size)
        for _ in range(2):  # one way and the other
            line = (np.minimum.accumulate(line - along, axis=-1) + along)[..., ::-1]
        found = np.moveaxis(line, -1, axis)
    return np.where(distance < most, distance, np.maximum(found / np.sqrt(3), most))


def _is_memory_short() -> bool:
    """Return whether this process cannot have a little more memory. Drivers then give other reasons for a fault."""
    try:
        return not bytearray(SPARE)
    except MemoryError:
        return True


def main() -> None:
    """Draw what the lines of the standard input ask for, until it ends."""
    answers = stopping.answers()

    def say(**values: object) -> None:
        print(json.dumps(values), file=answers)

    try:
        drawer = Drawer()
    except Exception as error:  # moderngl raises a plain Exception
        return say(error=str(error), no_memory=_is_memory_short())
    say(device=drawer.device, version=drawer.version)
    spent = 0.0
    for line in sys.stdin:
        asked = json.loads(line)
        try:
            scene = json.loads(Path(asked["scene"]).read_text("utf-8"))
            folder, size = Path(asked["scene"]).parent, tuple(asked.get("size", ()))
            scene["pictures"] = {part: (folder / name).read_bytes() for part, name in scene["pictures"].items()}
            target, kind = Path(asked["target"]), asked["kind"]
            if kind == "readout":
                target.write_bytes(drawer.readout(scene, size).tobytes())
            elif kind == "rays":
                rays = np.fromfile(asked["rays"], "<f4").reshape(2, -1, 4)
                target.write_bytes(drawer.followed(scene, rays).tobytes())
            else:
                sampling = size, asked["rays"], asked["wide_filter"], asked.get("part", 1)
                picture = drawer.picture(scene, *sampling, kind == "light", lambda part: say(part=part))
                if kind == "light":
                    target.write_bytes(packed(picture))
                else:  # fast; the file is larger
                    fromarray(picture).save(target, "PNG", compress_level=1, compress_type=RUN_LENGTHS)
        except OSError as error:  # such as a full disk: `gl_runner` raises the error, and this process continues
            say(error=error.strerror or str(error), errno=error.errno)
        except Exception as error:
            say(error=f"{type(error).__name__}: {error}")
        else:
            before, spent = spent, time.process_time()
            say(cpu_seconds=spent - before)  # of all threads, since the last picture


if __name__ == "__main__":
    with suppress(KeyboardInterrupt, BrokenPipeError):
        main()
