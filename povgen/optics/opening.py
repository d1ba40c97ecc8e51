"""The opening of a window: where it stands, what is in it, its frame and its outline."""

from typing import NamedTuple

import numpy as np

from povgen.optics.apparent import Element
from povgen.optics.faces import Floats
from povgen.optics.outline import Outline
from povgen.optics.pose import Pose


class Opening(NamedTuple):
    """A window: where its opening stands, what is in it, its outline, and how deep and wide its frame is."""

    pose: Pose
    sheet: Element
    frame: float = 0.0  # extent of the frame along the window's normal; `deep` makes it hold prisms or lenses
    own_outline: Outline | None = None  # None: a square, with the sheet's side
    rim: float = 0.0  # width of the frame's sides, which are taken as boxes; 0: prisms or lenses have black edges

    @property
    def outline(self) -> Outline:
        """The opening's outline."""
        return self.own_outline or Outline(self.sheet.aperture, self.sheet.aperture)

    @property
    def outer(self) -> Outline:
        """The outline of the opening and its frame."""
        width, height, is_round = self.outline
        return Outline(width + 2 * self.rim, height + 2 * self.rim, is_round)

    @property
    def edge(self) -> Floats:
        """Points of the outline, (n, 3), the first of which is the last."""
        turn = np.linspace(0, 2 * np.pi, 65 if self.outline.is_round else 5) + np.pi / 4
        x, y = (part if self.outline.is_round else np.sign(part) for part in (np.cos(turn), np.sin(turn)))
        own = np.stack((x * self.outline.width / 2, y * self.outline.height / 2, 0 * x), -1)
        return np.asarray(own @ self.pose.axes + self.pose.place)

    @property
    def deep(self) -> "Opening":
        """The window with a frame that is at least as deep as its prisms or lenses."""
        sheets = self.sheet.glass
        depth = sheets[-1].centre - sheets[0].centre + sheets[0].shape.length if sheets else 0.0
        return self._replace(frame=max(self.frame, depth))
