"""Limits of the methods, from the stability maps (docs/accuracy.md). povgen chooses settings by them, and
refuses scenes that exceed them, or warns.

`povgen verify --stability` measures each limit again, and fails if one no longer holds.
"""

# (a) Up to this condition number of the apparent position, eq. 7 is right to 1 pixel of 1280x960.
MAX_CONDITION = 150
# Predictions for prisms warn if they can be wrong by more than this, in pixels of 1280x960 (`optics.uncertainty`).
MAX_ERROR = 3
# (b) Up to this number of prisms, at most 1 in 10,000 rays on the designed path takes a wrong path in POV-Ray.
MAX_PRISMS = 3000
# (c) The narrowest air gap, in units of the pitch: POV-Ray misses narrower gaps between fine prisms. Up to WIDE_GAP the
# gap's width hardly matters.
MIN_GAP = 1e-3
WIDE_GAP = 0.09
# (d) Of the pixels that show a window of prisms, this fraction may be black because of the trace level, although light
# comes through there. This holds for each of these windows.
MAX_LOST_FRACTION = 0.05
# To find that trace level, rays are followed through at most this number of faces. A level of 240 can crash POV-Ray.
MAX_FACES = 180
# (e) At least this fraction of the window's rays should take the prisms' designed path.
MIN_DESIGNED_FRACTION = 0.25
# With partial reflection (--fresnel), rays that carry less than this share of the light are not followed.
LEAST_LIGHT = 0.01
# (f) The ideal sheets' camera interpolates rays in cells (`scene.cells`). Its error may be up to MAX_CAMERA_ERROR, in
# pixels of 1280x960. To keep it, up to MAX_CELLS cells across the window are used. POV-Ray takes about 1.3 CPU s to
# parse this number of cells.
MAX_CAMERA_ERROR = 0.03
MAX_CELLS = 100
# (g) With fewer pixels per prism, a picture without antialiasing is as wrong as one whose pixels are taken at random.
MIN_PIXELS_PER_PRISM = 1.2
# (h) If alpha, in degrees, times the number of prisms or lenses across the window is less than MOIRE, the ridges of the
# two sheets are nearly parallel, and dark bands appear (moire). With fewer prisms or lenses than MOIRE_COUNT, the bands
# do not stand out.
MOIRE = 800
MOIRE_COUNT = 40


def units_per_tile(pitch: float) -> int:
    """Return the size of a tile in POV-Ray's units. Its tolerances are fixed in these units: finer prisms need more."""
    return max(1000, round(1.2 / pitch))


def moire_alpha(count: float) -> float:
    """Return the alpha, degrees, below which two sheets of so many prisms make dark bands; 0: they make none."""
    return MOIRE / count if count >= MOIRE_COUNT else 0
