"""The architecture: what each module may import, and which module uses which external library."""

import ast
import re
import sys
from functools import cache
from pathlib import Path

import pytest

import povgen

PACKAGE = Path(povgen.__file__).parent
MODULES = {
    path.relative_to(PACKAGE).with_suffix("").as_posix().replace("/", "."): path for path in PACKAGE.rglob("*.py")
}
# The packages that each package may import. Each may also import the modules in BASE, which import no package.
LAYERS = {"fonts": set(), "optics": set(), "inputs": set()}
for _name in ("sheets", "objects", "scene", "rendering", "video", "liveview", "measure", "page", "paper", "cli"):
    LAYERS[_name] = set(LAYERS)
LAYERS["sheets"] -= {"inputs"}
LAYERS["page"] -= {"measure"}
LAYERS["paper"] -= {"liveview", "page"}
BASE = {"citation", "errors", "files", "limits", "progress", "record", "remedies", "settings", "stopping"}
BASE |= {"validation", "version"}
TOP = {"__init__", "__main__"}  # they may import everything


@cache
def imports(path):
    """Return what a module imports, also within its functions: modules, and names from modules."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{path}: a relative import; allowed: the full name"
            found |= {node.module} - {"povgen"} | {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def within(name, package):
    return f"{name}.".startswith(f"{package}.")


def own(name):
    """Return the modules of povgen that a module imports: `__init__` for a name that only povgen/__init__.py has."""
    found = {imported.removeprefix("povgen.") for imported in imports(MODULES[name]) if within(imported, "povgen")}
    defined = {"__init__" for imported in found if "." not in imported and imported not in {*MODULES, *LAYERS}}
    return {module for module in found if module in MODULES} | defined


def test_the_folders_are_the_layers():
    folders = {name.partition(".")[0] for name in MODULES if "." in name}
    assert folders == set(LAYERS)
    assert {name for name in MODULES if "." not in name} == BASE | TOP


@pytest.mark.parametrize("name", sorted(MODULES.keys() - TOP))
def test_a_module_imports_only_from_layers_below(name):
    package, inside, _ = name.partition(".")
    allowed = LAYERS[package] | {package} if inside else set()
    for module in own(name):
        above, deeper, _ = module.partition(".")
        assert above in allowed if deeper else module in BASE, f"{name} imports {module}"


def test_there_is_no_circle_of_imports():
    done, under_way = set(), []

    def visit(name):
        assert name not in under_way, " -> ".join([*under_way[under_way.index(name) :], name])
        if name not in done:
            under_way.append(name)
            for module in own(name):
                visit(module)
            done.add(under_way.pop())

    for name in sorted(MODULES.keys() - TOP):
        visit(name)


@pytest.mark.parametrize(
    ("library", "users"),
    [
        ("jinja2", {"scene.sdl"}),
        (
            "subprocess",
            {"rendering.povray", "rendering.gl_runner", "rendering.parallel", "inputs.readers", "video.encode"},
        ),
        ("imageio", {"video.encode"}),
        ("PIL", {"rendering", "inputs.fields", "inputs.picture_reader", "inputs.pictures", "objects", "video"}),
        ("matplotlib", {"measure.plotting"}),
        ("flip_evaluator", {"rendering.flip"}),
        ("playwright", {"measure.browser"}),
        ("OpenEXR", {"rendering.light", "inputs.picture_reader"}),
        ("moderngl", {"rendering.gl"}),
        ("click", {"cli"}),
        ("rich", {"cli", "progress"}),
        ("distributed", {"rendering.cluster"}),
        ("manifold3d", {"measure.part"}),
        ("trimesh", {"measure.part"}),
        ("dask", set()),
    ],
)
def test_one_module_uses_an_external_library(library, users):
    found = {
        name
        for name, path in MODULES.items()
        if any(f"{module}.".startswith(f"{library}.") for module in imports(path))
    }
    # a user is a module, or a layer whose modules all may use the library
    assert {next((user for user in users if f"{name}.".startswith(f"{user}.")), name) for name in found} == users


def test_public_names_are_listed_and_exist():
    assert {name for name in dir(povgen) if not name.startswith("_")} == set(povgen.__all__)
    assert all(getattr(povgen, name).__name__ == name for name in povgen.__all__)
    with pytest.raises(AttributeError, match="no attribute 'colour'"):
        povgen.__getattr__("colour")


def test_the_mathematics_needs_numpy_only():
    assert {module.split(".")[0] for module in imports(MODULES["optics.prism"])} == {"dataclasses", "math"}
    for name in {name for name in MODULES if name.startswith("optics.")}:
        external = {module.split(".")[0] for module in imports(MODULES[name])} - {"povgen"}
        assert external - sys.stdlib_module_names <= {"numpy"}
        assert all(module.startswith("optics.") for module in own(name))


def test_the_ray_trace_and_the_mesh_share_no_code():
    assert not imports(MODULES["scene.sdl"]) & {
        "povgen.optics.trace",
        "povgen.optics.apparent",
        "povgen.optics.paraxial",
    }
    mesh = (PACKAGE.parent / "templates" / "sheets.pov.j2").read_text()
    assert not set(re.findall(r"prism\.\w+", mesh))


def test_a_scene_knows_nothing_of_files():
    for name in ("presets", "eye_and_windows", "checks", "predictions"):
        assert not imports(MODULES[f"scene.{name}"]) & {"pathlib", "os", "povgen.files", "povgen.scene.sdl"}


def test_no_code_asks_which_preset_a_scene_is():
    """What a preset is, it states itself, or a property does."""
    sources = [*PACKAGE.rglob("*.py"), *PACKAGE.rglob("*.js"), *PACKAGE.rglob("*.glsl"), *PACKAGE.rglob("*.j2")]
    asks = re.compile(r"isinstance\([^)]*\b(Chess|Spheres)\b|[!=]=+ [\"'](chess|spheres)[\"']")
    found = [f"{path.name}: {line}" for path in sources for line in path.read_text().split("\n") if asks.search(line)]
    assert not found, found
