"""What becomes of the light in a window: the shares of designed, stray and lost light.

*Designed* rays take the designed path: in every sheet of prisms through one slanted facet, to the base, and through the
other slanted facet; in every sheet of lenses in by a lens, and out by the lens opposite. *Stray* rays leave on the far
side too, on another path. All others are *lost*: they come back on the side they came from, meet the frame or a black
top, miss a later window, or are not followed to their end. The shares of a scene are those of the rays from the eye to
places that are spread evenly over the front opening of the first window's frame (`scene.quantities`).
"""

from dataclasses import dataclass

import numpy as np

from povgen.optics.trace import End, Rays


@dataclass(frozen=True)
class Shares:
    """Shares of all rays. Their sum is 1."""

    designed: float  # leave on the designed path
    stray: float  # leave on the far side, on another path
    back: float  # leave on the side that they came from
    frame: float  # meet the frame
    absorbed: float  # meet a black top
    beside: float  # miss a later window
    unfinished: float  # have met the greatest allowed number of faces
    blocked: float  # meet an ideal sheet through which no light of their direction passes


def shares(rays: Rays) -> Shares:
    """Return what becomes of rays, a result of `trace.trace`. Raises ValueError if there are no rays."""
    if not rays.end.size:
        raise ValueError("0 rays; allowed: one or more")
    ends = {end.name.lower(): float(np.mean(rays.end == end)) for end in End}
    designed = float(np.mean(rays.designed))
    return Shares(designed=designed, stray=ends.pop("through") - designed, **ends)
