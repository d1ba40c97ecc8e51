"""Compare what POV-Ray renders with the equations and the exact ray trace: `povgen verify`.

A check renders probes: scenes whose colours encode numbers. Only `verify_profiles.ghosts` renders nothing. Each check
yields each measured value together with the value's bound. Random scenes have fixed seeds.
"""

from collections.abc import Iterator

from povgen.measure import verify_ideal, verify_light, verify_prisms, verify_profiles, verify_series
from povgen.measure.measured import Measured


def checks(sheet: str | None = None) -> Iterator[Measured]:
    """Measure everything, or only what concerns one model of the sheets: 'ideal' or 'detailed'."""
    if sheet != "detailed":
        yield from verify_ideal.ideal_positions()
        yield from verify_ideal.ideal_directions()
        yield from verify_ideal.chess_pieces()
        yield from verify_ideal.horizon()
        yield from verify_ideal.real_image()
        yield from verify_ideal.nothing_changed()
        yield from verify_ideal.other_sheets()
        yield from verify_series.series_positions()
        yield from verify_series.series_directions()
        yield from verify_series.series_image()
    if sheet != "ideal":
        yield from verify_prisms.every_pixel()
        yield from verify_prisms.finite_prisms()
        yield from verify_prisms.paraxial_prediction()
        yield from verify_prisms.other_prisms()
        yield from verify_prisms.errors_of_building()
        yield from verify_profiles.every_pixel()
        yield from verify_profiles.ghosts()
        yield from verify_series.series_pixels()
        yield from verify_series.series_prediction()
        yield from verify_light.black_tops()
        yield from verify_light.partial_reflection()
        yield from verify_light.reflected_light()
        yield from verify_prisms.hyperbola()
        yield from verify_prisms.designed_fraction()
