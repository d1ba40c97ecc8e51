"""What `results` returns: the columns of a table, which can also be a dataset of xarray."""

from collections.abc import Mapping
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from povgen import remedies
from povgen.citation import CITE, ENTRIES
from povgen.errors import InputError
from povgen.optics.faces import Indices
from povgen.record import Record, as_object, command
from povgen.scene.quantities import QUANTITIES, RAYS, SHARES, unit
from povgen.scene.scene import Scene
from povgen.version import __version__

Columns = Mapping[str, NDArray[Any]]
Axes = dict[str, tuple[Indices, Indices]]  # of each dimension: rows where its values are, and each row's value's number


class Table(dict[str, NDArray[Any]]):
    """Columns (n,) by their names: the parameters of n scenes, and quantities. It is a dictionary."""

    def __init__(self, parameters: Columns, quantities: Columns, scene: Scene | None) -> None:
        """Make a table. A parameter with the name of one of the quantities gets the prefix scene_.

        `scene` is one of the scenes, or None if there are none.
        """
        self.parameters = {f"scene_{name}" if name in quantities else name: each for name, each in parameters.items()}
        self.scene, self.command = scene, command()
        super().__init__({**self.parameters, **quantities})

    def to_xarray(self) -> Any:  # noqa: ANN401  (an xarray.Dataset)
        """Return an xarray.Dataset. Raises InputError if xarray is not installed.

        If the scenes are all combinations of some parameters' values, these parameters are its dimensions. Otherwise it
        has one dimension, scene. Attributes of variables are units and meanings. A share of traced rays has its
        standard error beside it, as designed_error. The dataset's attributes have BibTeX entries and, as JSON, a record
        with the call of `results` and all parameters of the first scene.
        """
        try:
            import xarray
        except ImportError:
            raise InputError(f"to_xarray needs xarray, which is not installed: {remedies.extra('xarray')}") from None

        frames = [] if self.scene is None else [{"scene": self.scene.name, **self.scene.model_dump(mode="json")}]
        record = Record(povgen=__version__, cite=CITE, command=self.command, **({"frames": frames} if frames else {}))
        about = {"source": f"povgen {__version__}", "references": ENTRIES, "record": as_object(bytes(record)).decode()}
        axes = _axes(self.parameters, len(next(iter(self.values()))))
        variables: dict[str, tuple[list[str], NDArray[Any], dict[str, str]]] = {}
        for name, column in self.items():
            if name in self.parameters:
                among, attributes = _axes_of(column, axes), {"units": unit(name)} if unit(name) else {}
            else:
                quantity = QUANTITIES[name]
                among, attributes = axes, {"units": quantity.unit or "1", "long_name": quantity.text}
            values = np.empty([len(rows) for rows, _ in among.values()], column.dtype)
            places = tuple(which for _, which in among.values())
            values[places] = column if places else column[0]
            variables[name] = [*among], values, attributes
        for name in SHARES & variables.keys() - self.parameters.keys():
            dimensions, values, attributes = variables[name]
            attributes["ancillary_variables"] = f"{name}_error"
            error = {"units": "1", "long_name": f"standard error of {name}, by {RAYS} rays"}
            variables[f"{name}_error"] = dimensions, np.sqrt(values * (1 - values) / RAYS), error
        return xarray.Dataset(variables, attrs=about).set_coords([*self.parameters])


def _axes(parameters: Columns, count: int) -> Axes:
    """Return the dimensions of a table of `count` rows: parameters, or scene if their values form no grid."""
    axes: Axes = {}
    combination, combinations = np.zeros(count, int), 1
    for name, column in parameters.items():
        _, rows, which = np.unique(column, return_index=True, return_inverse=True)
        rank = rows.argsort().argsort()  # in the order of the rows
        found, combination = np.unique(combination * len(rows) + which, return_inverse=True)
        if len(found) > combinations:
            axes[name], combinations = (np.sort(rows), rank[which]), len(found)
    if combinations == count == prod(len(rows) for rows, _ in axes.values()):
        return axes
    return {"scene": (np.arange(count), np.arange(count))}


def _axes_of(column: NDArray[Any], axes: Axes) -> Axes:
    """Return those of the dimensions on which a parameter's column depends: none, one, or all."""
    same = np.unique(column, return_inverse=True)[1]  # equal numbers for NaN
    if len(column) and not same.any():
        return {}
    for name, (rows, which) in axes.items():
        if np.array_equal(same[rows][which], same):
            return {name: (rows, which)}
    return axes
