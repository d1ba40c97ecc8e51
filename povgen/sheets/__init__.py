"""The kinds of sheets. Each file of this folder that defines a class with a `name` adds a kind."""

from importlib import import_module
from pkgutil import iter_modules

from povgen.sheets.sheet import Ideal, Parameter, Sheet

PAPER = ("detailed", "ideal", "single", "none")  # listed first


def _kinds() -> dict[str, type[Sheet]]:
    modules = [import_module(f"{__name__}.{module.name}") for module in iter_modules(__path__)]
    kinds = [kind for module in modules for kind in vars(module).values() if isinstance(kind, type)]
    found = {kind.name: kind for kind in kinds if issubclass(kind, Sheet) and "name" in vars(kind)}
    return {name: found[name] for name in dict.fromkeys((*PAPER, *sorted(found)))}


def _parameters() -> dict[str, list[Parameter]]:
    found: dict[str, list[Parameter]] = {}
    for kind in SHEETS.values():
        for parameter in kind.parameters:
            found.setdefault(parameter.name, []).append(parameter)
    return found


SHEETS = _kinds()
IDEAL = {name: kind for name, kind in SHEETS.items() if issubclass(kind, Ideal)}
OTHER = {name: kind for name, kind in IDEAL.items() if name not in PAPER}
PARAMETERS = _parameters()  # by name, a list: kinds that share a parameter can have different texts for it
# the kinds that use each parameter
USED_BY = {
    name: tuple(kind.name for kind in SHEETS.values() if name in {each.name for each in kind.parameters})
    for name in PARAMETERS
}
