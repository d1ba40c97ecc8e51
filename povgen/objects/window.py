"""A window of a room: a sheet in any pose."""

from typing import Annotated, Literal

from pydantic import Field

from povgen.objects.placed import Extent, Placed
from povgen.objects.sheet_fields import ParametersOfSheets, SheetName
from povgen.optics.opening import Opening
from povgen.optics.outline import Outline
from povgen.sheets import PARAMETERS, SHEETS
from povgen.sheets.sheet import Sheet

RIM = 0.15  # width of a frame's sides, tiles


class Window(Placed, ParametersOfSheets):
    """A window in any pose, with a sheet. Its place is the middle of the opening.

    Its z points to the side that the sheet's law calls behind: the eye of `Chess` sees it so.
    """

    sheet: SheetName = Field(default="ideal", description=f"model of the sheet: {', '.join(SHEETS)}")
    width: Annotated[float, Field(ge=0.1, le=100)] = Field(default=3, description="width, 0.1 to 100 tiles")
    height: Annotated[float, Field(ge=0.1, le=100)] | None = Field(
        default=None, description="height, 0.1 to 100 tiles (default: the width)"
    )
    outline: Literal["rectangle", "round"] = Field(
        default="rectangle", description="outline of the opening: rectangle or round"
    )
    frame: bool = Field(
        default=True, description="a frame around the opening; without it, sheets of glass have black edges"
    )

    @property
    def side(self) -> float:
        """The longer side, which the numbers of prisms and lenses count across, tiles."""
        return max(self.width, self.height or self.width)

    @property
    def optics(self) -> Sheet:
        """The sheet in the window."""
        kind = SHEETS[self.sheet]
        return kind({each.name: getattr(self, each.name) for each in kind.parameters}, self.side)

    @property
    def without_effect(self) -> set[str]:
        """The parameters that its sheet does not have."""
        return PARAMETERS.keys() - {each.name for each in self.optics.parameters}

    @property
    def depth(self) -> float:
        """Extent of frame and sheet along the window's z, tiles; 0 for an ideal sheet without a frame."""
        return max(self.side / 10 if self.frame else 0, 1.02 * self.optics.depth)

    @property
    def rim(self) -> float:
        """Width of the frame's sides, tiles; 0 without a frame."""
        return RIM if self.frame else 0

    @property
    def opening(self) -> Opening:
        """The window as in `optics.opening`."""
        outline = Outline(self.width, self.height or self.width, self.outline == "round")
        return Opening(self.pose, self.optics, self.depth, outline, self.rim)

    @property
    def box(self) -> Extent:
        """The room that it takes, with its frame: two corners of a box, in its own coordinates."""
        outer, z = self.opening.outer, self.depth / 2
        x, y = outer.width / 2, outer.height / 2
        return (-x, -y, -z), (x, y, z)
