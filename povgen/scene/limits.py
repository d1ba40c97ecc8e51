"""Where methods fail, as the stability maps found it (docs/accuracy.md): limits for scenes to keep, or to be warned of.

`povgen verify --stability` measures each anew and fails where one no longer holds.
"""

# (a) Largest condition number of the apparent position at which eq. 7 is right to 1 pixel of 1280x960; and the largest
# correction of it by the paraxial prediction, in such pixels, at which the latter is right to 3.
MAX_CONDITION = 150
MAX_CORRECTION = 8
# (b) Most prisms at which no more than 1 in 10,000 rays on the designed path goes astray.
MAX_PRISMS = 3000
# (c) Widths of the air gap, in units of the pitch, between which it matters little: narrower POV-Ray misses it.
GAP_RANGE = (1e-4, 0.09)
# (d) The fraction of the window's pixels that may stay black, for want of trace level, though light comes through.
MAX_LOST_FRACTION = 0.05
# The most faces that rays are traced through to find that level. A max_trace_level of 240 can crash POV-Ray.
MAX_FACES = 180
# (e) The least fraction of them on the prisms' designed path.
MIN_DESIGNED_FRACTION = 0.25
# (f) The error that the ideal sheet's camera may have off the axis, pixels of 1280x960, and the most cells a side to
# keep it: POV-Ray takes some 1.3 CPU s to read these.
MAX_CAMERA_ERROR = 0.03
MAX_CELLS = 100
# (g) Pixels per prism below which a picture without antialiasing is as far from right as pixels taken at random.
MIN_PIXELS_PER_PRISM = 1.2
# (h) alpha, degrees, below which parallel prisms make dark bands.
MIN_ALPHA = 3


def units_per_tile(prisms: int) -> int:
    """POV-Ray's tolerances are fixed in its own units: the finer the prisms, the larger the scene."""
    return max(1000, prisms // 2)
