"""From a spec to its movie."""

import tempfile
from collections.abc import Callable
from pathlib import Path

from povgen import __version__, encode, povray
from povgen.errors import validated
from povgen.frames import render_all
from povgen.rendering import Rendering
from povgen.spec import MovieSpec


def movie(
    spec: MovieSpec | str | Path,
    output: str | Path,
    *,
    workers: int | None = None,
    done: Callable[[], object] = lambda: None,
    **options,
) -> Path:
    """Render a movie to .mp4, .webm or .gif; returns its path, which names it only when it is whole.

    Options: quality, size, antialias and timeout, as of `Rendering`. `done` is called after each frame.
    Raises InputError for what cannot be before anything is rendered, PovrayError where POV-Ray fails.
    """
    if not isinstance(spec, MovieSpec):
        spec = MovieSpec.load(spec)
    rendering = validated(Rendering, options)
    scenes = spec.scenes(rendering.quality)
    output = encode.checked_output(Path(output), encode.FORMATS)
    sampling = "off" if rendering.antialias is None else ",".join(f"{x:g}" for x in rendering.antialias)
    tags = {
        "title": spec.title,
        "comment": spec.model_dump_json(exclude_none=True),
        "description": f"povgen {__version__}, POV-Ray {povray.version()}, antialias {sampling}",
    }
    with tempfile.TemporaryDirectory(prefix=f".{output.name}.", dir=output.parent) as folder:
        part = Path(folder) / f"movie{output.suffix.lower()}"
        encode.encode(render_all(scenes, rendering, workers, done), part, spec.rate(rendering.quality), tags)
        part.replace(output)
    return output
