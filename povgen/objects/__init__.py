"""What stands in a scene. Each file of this folder that defines a class with a `kind` adds a kind of object."""

from importlib import import_module
from pkgutil import iter_modules

from povgen.objects.scene_object import SceneObject


def _kinds() -> dict[str, type[SceneObject]]:
    modules = [import_module(f"{__name__}.{module.name}") for module in iter_modules(__path__)]
    kinds = [kind for module in modules for kind in vars(module).values() if isinstance(kind, type)]
    return {kind.kind: kind for kind in kinds if issubclass(kind, SceneObject) and "kind" in vars(kind)}


OBJECTS = _kinds()
