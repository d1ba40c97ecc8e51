"""The house: who may import whom."""

import ast
import math
import re
from pathlib import Path

import povgen

HOUSE = Path(povgen.__file__).parent


def imports(path):
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def only(*allowed, of):
    """Which modules import something beginning with `of`, beside those allowed, by their name or their package's."""
    found = {path for path in HOUSE.rglob("*.py") if any(f"{name}.".startswith(f"{of}.") for name in imports(path))}
    return {path.stem for path in found if not {path.stem, path.parent.name} & {*allowed}}


def test_each_trade_has_one_house():
    assert not only("sdl", of="jinja2")
    assert not only("povray", of="subprocess")
    assert not only("encode", of="imageio")
    assert not only("plotting", of="matplotlib")
    assert not only("overlay", "frames", of="PIL")  # frames only reads back the PNG that it hands out as an array
    assert not only("speed", of="flip_evaluator")
    assert not only("cli", "commands", of="typer")
    assert not only("cli", "commands", of="rich")
    assert not only("cluster", of="distributed") and not only(of="dask")


def test_the_mathematics_is_numpy_alone():
    assert imports(HOUSE / "optics" / "rotation.py") == {"numpy"}
    assert imports(HOUSE / "optics" / "prism.py") <= {"math"} | {f"math.{name}" for name in vars(math)}
    for name in ("paraxial", "trace"):
        own = {"povgen.optics", "povgen.optics.prism"}
        assert {module.split(".")[0] for module in imports(HOUSE / "optics" / f"{name}.py") - own} <= {
            *("numpy", "dataclasses", "enum")
        }


def test_the_ray_trace_shares_nothing_with_what_builds_the_mesh():
    assert not imports(HOUSE / "scene" / "sdl.py") & {"povgen.optics.trace", "povgen.optics.paraxial"}
    mesh = (HOUSE / "templates" / "sheets.pov.j2").read_text()
    assert not set(re.findall(r"prism\.\w+", mesh))


def test_scenes_know_nothing_of_files_and_processes():
    assert not imports(HOUSE / "scene" / "models.py") & {"pathlib", "os", "povgen.scene.sdl"}
