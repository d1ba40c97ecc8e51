"""Pages about the Python interface, in Markdown, made from the docstrings. docs/website.py puts them into the site.

They describe the public names: those of `povgen`, and those of the modules of `povgen.optics`, which need only numpy.
"""

import inspect
import re
from collections.abc import Iterator
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType, NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin

import numpy as np
from numpy.typing import ArrayLike

import povgen
from povgen.validation import Model

WIDTH = 100  # characters; a longer signature has a line for each parameter


def pages() -> dict[str, str]:
    """Return the text of each module's page by the module's name."""
    optics = import_module("povgen.optics")
    parts = [import_module(f"povgen.optics.{part.name}") for part in iter_modules(optics.__path__)]
    return {module.__name__: _page(module) for module in (povgen, *parts)}


def _page(module: ModuleType) -> str:
    names = povgen.__all__ if module is povgen else [name for name, _ in _own(module)]
    parts = [f"# {module.__name__}", markdown(inspect.getdoc(module) or "")]
    for name in names:
        parts += _described(name, getattr(module, name), "##")
    return "\n\n".join(parts) + "\n"


def _own(module: ModuleType) -> Iterator[tuple[str, Any]]:
    """Yield the public functions and classes that a module defines, in their order there."""
    for name, value in vars(module).items():
        if not name.startswith("_") and getattr(value, "__module__", "") == module.__name__ and callable(value):
            yield name, value


def _described(name: str, value: Any, level: str) -> Iterator[str]:
    """Yield the heading, the signature and the docstring of a function or class, and of the class's public methods."""
    yield f"{level} {name}"
    if inspect.isclass(value) and issubclass(value, Exception):
        yield f"```python\nclass {name}({value.__base__.__name__})\n```"
    else:
        yield f"```python\n{'class ' * inspect.isclass(value)}{name}{signature(value)}\n```"
    yield markdown(inspect.getdoc(value) or "")
    if not inspect.isclass(value):
        return
    for method, member in _members(value):
        yield f"{level}# {name}.{method}"
        if isinstance(member, (staticmethod, classmethod)):
            member = member.__func__
        function = getattr(member, "fget", None) or getattr(member, "func", None) or member  # of a property
        if function is member:
            yield f"```python\n{method}{signature(function)}\n```"
        else:
            yield f"```python\n{method}: {shown(inspect.signature(function).return_annotation)}\n```"
        yield markdown(inspect.getdoc(function) or "")


def _members(value: type) -> Iterator[tuple[str, Any]]:
    """Yield the public methods and properties that povgen's own classes define and describe."""
    seen = set()
    for each in value.__mro__:
        if not each.__module__.startswith("povgen"):
            continue
        for name, member in [*vars(each).items()]:  # to describe a member can complete a class of parameters
            function = (
                getattr(member, "__func__", None) or getattr(member, "fget", None) or getattr(member, "func", member)
            )
            described = inspect.isfunction(function) and function.__doc__
            if described and not name.startswith(("_", "model_")) and name not in seen:
                seen.add(name)
                yield name, member


def signature(value: Any) -> str:
    """Return a signature as in Python, with short types. A model lists its parameters in its docstring."""
    if inspect.isclass(value) and issubclass(value, Model):
        return "(**parameters)"
    found = inspect.signature(value)
    parts, star = [], False
    for parameter in found.parameters.values():
        if parameter.name == "self" or parameter.name == "cls":
            continue
        if parameter.kind is parameter.KEYWORD_ONLY and not star:
            parts.append("*")
        star |= parameter.kind in (parameter.KEYWORD_ONLY, parameter.VAR_POSITIONAL)
        stars = {parameter.VAR_POSITIONAL: "*", parameter.VAR_KEYWORD: "**"}.get(parameter.kind, "")
        text = f"{stars}{parameter.name}"
        if parameter.annotation is not parameter.empty:
            text += f": {shown(parameter.annotation)}"
        parts.append(text if parameter.default is parameter.empty else f"{text} = {parameter.default!r}")
    result = "" if inspect.isclass(value) else f" -> {shown(found.return_annotation)}"
    line = f"({', '.join(parts)}){result}"
    return line if len(line) < WIDTH else "(\n    " + ",\n    ".join(parts) + f",\n){result}"


def shown(kind: Any) -> str:
    """Return a type as text, without the names of modules."""
    origin, parts = get_origin(kind), get_args(kind)
    if kind in (None, NoneType):
        return "None"
    if kind == ArrayLike:
        return "ArrayLike"
    if kind is inspect.Signature.empty:
        return "Any"
    if isinstance(kind, str):
        return re.sub(r"\b(?:[a-z_]+\.)+(?=[A-Za-z])", "", kind)
    if origin is np.ndarray:
        return f"NDArray[{shown(get_args(parts[1])[0])}]"
    if origin in (Union, UnionType):
        if {*get_args(ArrayLike)} <= {*parts}:  # Python has joined ArrayLike with another type
            parts = (ArrayLike, *(part for part in parts if part not in get_args(ArrayLike)))
        return " | ".join(shown(part) for part in parts)
    if origin is Literal:
        return f"Literal[{', '.join(map(repr, parts))}]"
    if kind is Ellipsis or not origin:
        return "..." if kind is Ellipsis else getattr(kind, "__name__", str(kind))
    inside = ", ".join(f"[{', '.join(map(shown, part))}]" if isinstance(part, list) else shown(part) for part in parts)
    return f"{origin.__name__}[{inside}]"


def markdown(docstring: str) -> str:
    """Return a docstring as Markdown: outside code, characters that would be markup stay as they are."""
    parts = re.split(r"(``?[^`]+``?)", docstring)
    return "".join(part if part.startswith("`") else re.sub(r"([*_<|\[\]])", r"\\\1", part) for part in parts)
