"""Laws of ideal sheets: the direction of a ray behind a sheet, as text that several languages read alike.

The languages are Python (with numpy), POV-Ray's scene description language, GLSL and JavaScript.

A law is three expressions: the x, y and z components of the ray's new direction, behind the sheet. They may contain

- x, y, z: the unit direction, before the sheet, of a ray that comes from the eye (z > 0);
- X, Y: where the ray meets the sheet, from the window's centre, tiles;
- the names of the sheet's parameters; angles are in radians;
- decimal numbers, + - * / and parentheses, and the functions sqrt, sin, cos, abs, min, max and pow (of a base that is
  not negative).

x points right and y up, as the eye sees them. The length of the new direction does not matter. The ray passes
only if the z component of the new unit direction is above 1e-6. Light runs along the same path, towards the eye.
"""

import ast
import keyword
import re
from collections.abc import Collection, Iterable, Mapping
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

# The functions, with the number of their arguments and numpy's name.
FUNCTIONS = {
    "sqrt": (1, "sqrt"),
    "sin": (1, "sin"),
    "cos": (1, "cos"),
    "abs": (1, "abs"),
    "min": (2, "minimum"),
    "max": (2, "maximum"),
    "pow": (2, "power"),
}
RAY = ("x", "y", "z", "X", "Y")
LONGEST, DEEPEST = 1000, 100  # maximum number of characters of a law, and maximum depth of its syntax tree
# Numbers in a law are 0, or from SMALLEST to LARGEST: shaders compute with 32-bit numbers. Products can be outside.
SMALLEST, LARGEST = 1e-30, 1e30
NUMBER = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[+-]?[0-9]+)?"
LEAST_Z = 1e-6  # light passes if z of the new direction, divided by its length, is greater
_OPERATORS = (ast.Add, ast.Sub, ast.Mult, ast.Div)


class Law:
    """A law, checked against the grammar. Two laws are equal if their expressions are."""

    def __init__(self, text: str, parameters: Collection[str] = ()) -> None:
        """Read a law: three expressions, separated by commas.

        Raises ValueError if the text does not follow the grammar, is too long or too deeply nested, or if the name of a
        parameter is not allowed. If possible, the message states the place in the text.
        """
        self.parameters = tuple(parameters)
        for name in self.parameters:
            if (
                not re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII)
                or name in (*RAY, *FUNCTIONS)
                or keyword.iskeyword(name)
            ):
                raise ValueError(
                    f"parameter {name!r}; allowed: a name of letters, digits and _ that begins with a letter, "
                    f"but not {', '.join((*RAY, *FUNCTIONS))}, nor a keyword of Python"
                )
        self._parts = _Reader(text, self.parameters).parts

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Law) and str(self) == str(other)

    def __hash__(self) -> int:
        return hash(str(self))

    def __getstate__(self) -> dict[str, Any]:
        """Return what other processes are sent: compiled code cannot be."""
        return {name: value for name, value in vars(self).items() if name != "_code"}

    def __str__(self) -> str:
        return self._text

    @cached_property
    def _text(self) -> str:
        return ", ".join(self.expressions())

    def bend(self, direction: ArrayLike, place: ArrayLike, values: Mapping[str, float]) -> Any:  # noqa: ANN401
        """Return the unit directions (..., 3) behind the sheet. They are NaN where no light passes.

        `direction` (..., 3) are vectors with z > 0, of lengths from 1e-150 to 1e150. `place` is complex, X + iY, and
        broadcasts. `values` has a number or an array for each name of a parameter in the law; angles are in radians.
        """
        return self._bent(self._code, direction, place, values, "float64")

    def bend_in_32_bits(self, direction: ArrayLike, place: ArrayLike, values: Mapping[str, float]) -> Any:  # noqa: ANN401
        """Return what `bend` returns, but computed as shaders do: with 32-bit numbers, except for the `constants`."""
        constants = {f"c{n}": number for n, number in enumerate(self.constant_numbers(values))}
        return self._bent(_compiled(self._extracted[1]), direction, place, constants, "float32")

    def _bent(self, code: Any, direction: Any, place: Any, values: Mapping[str, float], kind: str) -> Any:  # noqa: ANN401
        d = np.moveaxis(np.asarray(direction, float), -1, 0)  # components first: numpy takes a third of the time
        with np.errstate(all="ignore"):  # light that does not pass is NaN
            x, y, z = d / _length(d)
            at = np.asarray(place, complex)
            ray = {"x": x, "y": y, "z": z, "X": at.real, "Y": at.imag}
            parts = _evaluated(code, {**values, **ray}, kind)
            bent = np.stack(np.broadcast_arrays(*parts, x, at.real)[:3])
            bent /= abs(bent).max(0)  # squares of very large or small numbers are inf or 0
            bent /= _length(bent)
            return np.moveaxis(np.where(bent[2] > LEAST_Z, bent, np.nan), 0, -1)

    @property
    def names(self) -> set[str]:
        """The names in the law, of the ray and of parameters."""
        nodes = (node for part in self._parts for node in ast.walk(part))
        return {node.id for node in nodes if isinstance(node, ast.Name)} - {*FUNCTIONS}

    def check_divisions(self, values: Mapping[str, float]) -> None:
        """Raise ValueError if a divisor is 0 for every ray, because POV-Ray refuses such a law.

        `values` has the parameters' values by name. A part of the law without x, y, z, X and Y (see `constants`) may
        contain a division by 0, also in POV-Ray: with k = 0, 1/k is infinite, and x/(1/k) is 0.
        """
        constants, parts = self._extracted
        divisions = (node for part in parts for node in ast.walk(part) if isinstance(node, ast.BinOp))
        for below in (node.right for node in divisions if isinstance(node.op, ast.Div)):
            names = {each.id for each in ast.walk(below) if isinstance(each, ast.Name)} - {*FUNCTIONS}
            if not names & {*RAY}:  # the same for all rays
                numbers = {f"c{n}": number for n, number in enumerate(self.constant_numbers(values))}
                with np.errstate(all="ignore"):
                    is_zero = _evaluated(_compiled([below]), numbers)[0] == 0
                if is_zero:
                    written = constants[int(below.id[1:])] if isinstance(below, ast.Name) else below
                    raise ValueError(f"{ast.unparse(written)!r} is 0; allowed: to divide by other numbers")

    @property
    def uses_place(self) -> bool:
        """Whether the law differs from place to place."""
        return bool(self.names & {"X", "Y"})

    @property
    def is_smooth(self) -> bool:
        """Whether x, y, z, X and Y occur in no function except sin and cos: then the law has no kinks."""
        calls = (node for part in self._parts for node in ast.walk(part) if isinstance(node, ast.Call))
        others = (call for call in calls if isinstance(call.func, ast.Name) and call.func.id not in ("sin", "cos"))
        return not any(map(_of_the_ray, others))

    @property
    def only_scales_z(self) -> bool:
        """Whether z behind the sheet is written as z before it, multiplied or divided by constants.

        If their product is positive, light passes everywhere, unless its new direction is nearly parallel to the sheet
        (`LEAST_Z`).
        """
        part = self._parts[2]
        while not isinstance(part, ast.Name):
            match part:
                case ast.UnaryOp(ast.USub(), rest):
                    part = rest
                case ast.BinOp(rest, ast.Mult() | ast.Div(), factor) if not _of_the_ray(factor):
                    part = rest
                case ast.BinOp(factor, ast.Mult(), rest) if not _of_the_ray(factor):
                    part = rest
                case _:
                    return False
        return part.id == "z"

    @cached_property
    def _code(self) -> Any:  # noqa: ANN401  (a code object)
        return _compiled(self._parts)

    @cached_property
    def _extracted(self) -> tuple[list[ast.expr], list[ast.expr]]:
        """The `constants` (see below), and the three expressions with names in place of the constants."""
        constants: list[ast.expr] = []
        return constants, [_Extract(constants).visit(_copy(part)) for part in self._parts]

    def expressions(self, names: Mapping[str, str] = {}) -> list[str]:
        """Return the three expressions. `names` has what replaces names in them, also those of functions."""
        return [_written(part, names) for part in self._parts]

    def constants(self, names: Mapping[str, str] = {}) -> list[str]:
        """Return the parts of the law that contain a parameter and none of x, y, z, X and Y.

        Each part is as large as possible, and is returned once. Names in them are replaced as in `expressions`.
        """
        return [_written(part, names) for part in self._extracted[0]]

    def constant_numbers(self, values: Mapping[str, float]) -> list[float]:
        """Return the values of the `constants`. `values` has the parameters' values by name."""
        with np.errstate(all="ignore"):
            return [float(number) for number in _evaluated(_compiled(self._extracted[0]), values)]

    def with_constants(self, names: Mapping[str, str] = {}) -> list[str]:
        """Return the three expressions with the names c0, c1, ... in place of the `constants`."""
        return [_written(part, names) for part in self._extracted[1]]


class _Reader:
    """The text of a law, as three expressions of the grammar."""

    def __init__(self, text: str, parameters: tuple[str, ...]) -> None:
        self.text, self.names = text, (*RAY, *parameters)
        if len(text) > LONGEST:
            raise ValueError(f"{len(text)} characters; allowed: up to {LONGEST}")
        # Python's parser accepts comments and texts, numbers such as 0x1F and 1_000, and with a warning `1if x else y`
        wrong = rf"(?<![\w.])(?!{NUMBER}(?![\w.]))\.?[0-9][\w.]*(?:(?<=e)[+-][\w.]*)?"
        if other := re.search(rf"[#'\"]|{wrong}", text, re.IGNORECASE):
            raise self._error(*other.span())
        line = re.sub(r"\s", " ", text)
        self.expression = line.strip()
        self.start = line.find(self.expression)
        try:
            tree = ast.parse(self.expression, mode="eval").body if self.expression else ast.Tuple([], ast.Load())
        except SyntaxError as error:
            raise self._error(min(self.start + max((error.offset or 1) - 1, 0), len(text))) from None
        except (ValueError, RecursionError, MemoryError):  # a NUL, or hundreds of parentheses
            raise ValueError(
                "cannot be read; allowed: three expressions, for x, y and z, separated by commas"
            ) from None
        parts = tree.elts if isinstance(tree, ast.Tuple) else [tree]
        if len(parts) != 3:
            raise ValueError(f"{len(parts)} expressions; allowed: three, for x, y and z, separated by commas")
        if _depth(tree) > DEEPEST:
            raise ValueError(f"nested in more than {DEEPEST} levels; allowed: up to {DEEPEST}")
        self.parts = tuple(self._checked(part) for part in parts)

    def _error(self, start: int, end: int | None = None) -> ValueError:
        wrong = self.text[start : (start + 12 if end is None else end)]
        functions = ", ".join(FUNCTIONS)
        return ValueError(
            f"{wrong!r} at character {start + 1}; allowed: decimal numbers (0, or {SMALLEST:g} to {LARGEST:g}), "
            f"+ - * / ( ), {', '.join(self.names)}, and the functions {functions}"
        )

    def _checked(self, node: ast.expr) -> ast.expr:
        """Return an expression in the form that every language reads alike. Integers become decimal numbers."""
        match node:
            case ast.BinOp(left, op, right) if isinstance(op, _OPERATORS):
                return ast.BinOp(self._checked(left), op, self._checked(right))
            case ast.UnaryOp(ast.UAdd(), operand):
                return self._checked(operand)
            case ast.UnaryOp(ast.USub(), operand):
                match self._checked(operand):
                    case ast.UnaryOp(ast.USub(), twice):  # `--` is another operator in JavaScript
                        return twice
                    case checked:
                        return ast.UnaryOp(ast.USub(), checked)
            case ast.Constant(float() | int() as number) if not isinstance(number, bool):
                if number == 0 or SMALLEST <= abs(number) <= LARGEST:
                    return ast.Constant(float(number))
            case ast.Name(name) if name in self.names:
                return ast.Name(name, ast.Load())
            case ast.Call(ast.Name(name), arguments, []) if name in FUNCTIONS and len(arguments) == FUNCTIONS[name][0]:
                return ast.Call(ast.Name(name, ast.Load()), [self._checked(each) for each in arguments], [])
        text, ends = self.expression.encode(), (node.col_offset, node.end_col_offset or 0)  # Python counts bytes
        start, end = (self.start + len(text[:at].decode()) for at in ends)
        raise self._error(start, end)


def _depth(tree: ast.AST) -> int:
    """Return how many levels a tree has. A loop counts them, because recursion could exceed Python's limit."""
    depth, level = 0, [tree]
    while level:
        depth, level = depth + 1, [child for node in level for child in ast.iter_child_nodes(node)]
    return depth


class _Extract(ast.NodeTransformer):
    """Put the names c0, c1, ... in place of the parts that `Law.constants` returns, and collect these parts."""

    def __init__(self, constants: list[ast.expr]) -> None:
        self.constants = constants

    def visit(self, node: ast.AST) -> Any:  # noqa: ANN401  (as ast declares it)
        names = {each.id for each in ast.walk(node) if isinstance(each, ast.Name)} - {*FUNCTIONS}
        if not isinstance(node, ast.expr) or not names or names & {*RAY}:
            return self.generic_visit(node) if names else node
        texts = [ast.unparse(each) for each in self.constants]
        if ast.unparse(node) not in texts:
            self.constants.append(node)
            texts.append(ast.unparse(node))
        return ast.Name(f"c{texts.index(ast.unparse(node))}", ast.Load())


class _Numpy(ast.NodeTransformer):
    """Wrap every number in numpy's abs. The result is a number of numpy, for which 1/0 is infinite.

    Numbers in the tree are not negative, so abs does not change their values.
    """

    def visit_Constant(self, node: ast.Constant) -> ast.Call:
        return ast.Call(ast.Name("abs", ast.Load()), [node], [])


def _compiled(parts: Iterable[ast.expr]) -> Any:  # noqa: ANN401  (a code object)
    """Return the code of a tuple of expressions."""
    body = _Numpy().visit(ast.Tuple([_copy(part) for part in parts], ast.Load()))
    return compile(ast.fix_missing_locations(ast.Expression(body)), "<law>", "eval")


def _evaluated(code: Any, values: Mapping[str, Any], kind: str = "float64") -> Any:  # noqa: ANN401
    """Evaluate the code of several expressions. `values` has a number or an array for each name. Return a tuple.

    All is computed with numbers of this kind of numpy's.
    """

    def number(value: Any) -> Any:  # noqa: ANN401
        return np.asarray(value, kind)[()]

    names = {name: getattr(np, function) for name, (_, function) in FUNCTIONS.items()}
    names["abs"] = lambda value: np.abs(number(value))  # `_Numpy` wraps every number
    names |= {name: number(value) for name, value in values.items()} | {"__builtins__": {}}
    return eval(code, names)  # safe: the grammar has only these names and calls, and no attributes


def _length(vectors: Any) -> Any:  # noqa: ANN401  (of any kind of numbers)
    """Return the lengths (...) of vectors (3, ...)."""
    return np.sqrt(np.einsum("i...,i...", vectors, vectors))


def _copy(node: Any) -> Any:  # noqa: ANN401
    return ast.parse(ast.unparse(node), mode="eval").body


def _of_the_ray(node: ast.AST) -> bool:
    """Return whether an expression contains x, y, z, X or Y."""
    return any(isinstance(each, ast.Name) and each.id in RAY for each in ast.walk(node))


def _written(node: ast.expr, names: Mapping[str, str]) -> str:
    copy = _copy(node)
    for each in ast.walk(copy):
        if isinstance(each, ast.Name):
            each.id = names.get(each.id, each.id)
    return ast.unparse(copy)
