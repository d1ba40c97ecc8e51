"""What `results` returns: the columns of a table, which can also be a dataset of xarray."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from povgen import remedies
from povgen.citation import CITE, ENTRIES
from povgen.errors import InputError
from povgen.record import Record, as_object, command
from povgen.scene.quantities import QUANTITIES, RAYS, SHARES, unit
from povgen.scene.scene import Scene
from povgen.version import __version__

Columns = Mapping[str, NDArray[Any]]


class Table(dict[str, NDArray[Any]]):
    """Columns (n,) by their names: the parameters of n scenes, and quantities. It is a dictionary."""

    def __init__(
        self, parameters: Columns, quantities: Columns, scene: Scene | None, lengths: Mapping[str, int] | None = None
    ) -> None:
        """Make a table. A parameter with the name of one of the quantities gets the prefix scene_.

        `scene` is one of the scenes, or None if there are none. `lengths` are those of the lists of values, by their
        parameters' names, if the rows are all combinations of these values.
        """

        def named(name: str) -> str:
            return f"scene_{name}" if name in quantities else name

        self.parameters = {named(name): each for name, each in parameters.items()}
        self.lengths = {named(name.replace(".", "_")): length for name, length in (lengths or {}).items()}
        self.scene, self.command = scene, command()
        super().__init__({**self.parameters, **quantities})

    def to_xarray(self) -> Any:  # noqa: ANN401  (an xarray.Dataset)
        """Return an xarray.Dataset. Raises InputError if xarray is not installed.

        Its dimensions are the parameters for which `results` was given lists of values. Without lists it has one
        dimension, scene. Attributes of variables are units and meanings. A share of traced rays has its standard error
        beside it, as designed_error. The dataset's attributes have BibTeX entries and, as JSON, a record with the call
        of `results` and all parameters of the first scene.
        """
        try:
            import xarray
        except ImportError:
            raise InputError(f"to_xarray needs xarray, which is not installed: {remedies.extra('xarray')}") from None

        frames = [] if self.scene is None else [{"scene": self.scene.name, **self.scene.model_dump(mode="json")}]
        record = Record(povgen=__version__, cite=CITE, command=self.command, **({"frames": frames} if frames else {}))
        about = {"source": f"povgen {__version__}", "references": ENTRIES, "record": as_object(bytes(record)).decode()}
        lengths = self.lengths or {"scene": len(next(iter(self.values())))}
        variables: dict[str, tuple[list[str], NDArray[Any], dict[str, str]]] = {}
        for name, column in self.items():
            among = [*lengths]
            if name in self.parameters:
                attributes = {"units": unit(name)} if unit(name) else {}
                # its own list, or that of which it is a component, such as eye for eye_x
                own = [each for each in lengths if name.startswith((f"{each}_", f"{each.removeprefix('scene_')}_"))]
                lists = [name] if name in lengths else own
                among = lists or among
            else:
                quantity = QUANTITIES[name]
                attributes = {"units": quantity.unit or "1", "long_name": quantity.text}
            values = column.reshape([*lengths.values()])[tuple(slice(None) if d in among else 0 for d in lengths)]
            variables[name] = among, values, attributes
        for name in SHARES & variables.keys() - self.parameters.keys():
            dimensions, values, attributes = variables[name]
            attributes["ancillary_variables"] = f"{name}_error"
            error = {"units": "1", "long_name": f"standard error of {name}, by {RAYS} rays"}
            variables[f"{name}_error"] = dimensions, np.sqrt(values * (1 - values) / RAYS), error
        return xarray.Dataset(variables, attrs=about).set_coords([*self.parameters])
