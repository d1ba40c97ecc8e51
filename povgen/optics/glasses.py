"""Refractive indices of glasses, plastics and water, at 20 degrees C (CaF2 24) in air, from dispersion formulas.

All formulas are Sellmeier's: n^2 - 1 = sum of B w^2/(w^2 - C), with the wavelength w in micrometres. The glasses are
Schott's (catalogue of 2017-01-20); BK7 is its N-BK7. fused-silica: Malitson, J. Opt. Soc. Am. 55, 1205 (1965). CaF2:
Malitson, Appl. Opt. 2, 1103 (1963). PMMA and polycarbonate: measured by Sultanova, Kasarova and Nikolov, Acta Phys.
Pol. A 116, 585 (2009), formula fitted by the refractiveindex.info database. water: Daimon and Masumura, Appl. Opt. 46,
3811 (2007); against vacuum, which is 0.0004 more than against air.
"""

from numbers import Real
from typing import NamedTuple


class Glass(NamedTuple):
    """A glass: the formula's coefficients, and the wavelengths for which it holds."""

    range: tuple[float, float]  # micrometres
    terms: tuple[tuple[float, float], ...]  # B, and C in square micrometres


GLASSES = {
    "BK7": Glass((0.3, 2.5), ((1.03961212, 0.00600069867), (0.231792344, 0.0200179144), (1.01046945, 103.560653))),
    "N-K5": Glass((0.31, 2.5), ((1.08511833, 0.00661099503), (0.199562005, 0.024110866), (0.930511663, 111.982777))),
    "N-FK51A": Glass(
        (0.29, 2.5), ((0.971247817, 0.00472301995), (0.216901417, 0.0153575612), (0.904651666, 168.68133))
    ),
    "N-BAK4": Glass(
        (0.334, 2.5), ((1.28834642, 0.00779980626), (0.132817724, 0.0315631177), (0.945395373, 105.965875))
    ),
    "N-SK16": Glass((0.31, 2.5), ((1.34317774, 0.00704687339), (0.241144399, 0.0229005), (0.994317969, 92.7508526))),
    "F2": Glass((0.32, 2.5), ((1.34533359, 0.00997743871), (0.209073176, 0.0470450767), (0.937357162, 111.886764))),
    "N-BAF10": Glass((0.35, 2.5), ((1.5851495, 0.00926681282), (0.143559385, 0.0424489805), (1.08521269, 105.613573))),
    "N-LAK8": Glass((0.31, 2.5), ((1.33183167, 0.00620023871), (0.546623206, 0.0216465439), (1.19084015, 82.5827736))),
    "N-SF10": Glass((0.38, 2.5), ((1.62153902, 0.0122241457), (0.256287842, 0.0595736775), (1.64447552, 147.468793))),
    "N-SF11": Glass((0.37, 2.5), ((1.73759695, 0.013188707), (0.313747346, 0.0623068142), (1.89878101, 155.23629))),
    "N-LASF9": Glass((0.365, 2.5), ((2.00029547, 0.0121426017), (0.298926886, 0.0538736236), (1.80691843, 156.530829))),
    "N-SF66": Glass((0.39, 2.5), ((2.0245976, 0.0147053225), (0.470187196, 0.0692998276), (2.59970433, 161.817601))),
    "fused-silica": Glass(
        (0.21, 3.71), ((0.6961663, 0.0684043**2), (0.4079426, 0.1162414**2), (0.8974794, 9.896161**2))
    ),
    "CaF2": Glass((0.23, 9.7), ((0.5675888, 0.050263605**2), (0.4710914, 0.1003909**2), (3.8484723, 34.649040**2))),
    "PMMA": Glass((0.4368, 1.052), ((1.1819, 0.011313),)),
    "polycarbonate": Glass((0.4368, 1.052), ((1.4182, 0.021304),)),
    "water": Glass(
        (0.182, 1.129),
        (
            (0.5684027565, 0.005101829712),
            (0.1726177391, 0.01821153936),
            (0.02086189578, 0.02620722293),
            (0.1130748688, 10.69792721),
        ),
    ),
}


def index(glass: str, wavelength: float) -> float:
    """Return the refractive index n of a glass at a wavelength in metres, as all wavelengths in this package.

    Raises ValueError for a name that is not in `GLASSES`, and for a wavelength at which the glass's formula does not
    hold.
    """
    if glass not in GLASSES:
        raise ValueError(f"glass = {glass!r}: unknown; allowed: {', '.join(GLASSES)}")
    if not isinstance(wavelength, Real):
        raise ValueError(f"wavelength = {wavelength!r}: allowed: one number, metres")
    (least, most), terms = GLASSES[glass]
    micrometres = 1e6 * wavelength
    if not (1 - 1e-9) * least <= micrometres <= (1 + 1e-9) * most:  # for rounding errors
        ends = f"{1000 * least:g} to {1000 * most:g} nm"
        raise ValueError(f"wavelength of {1000 * micrometres:g} nm: outside the formula of {glass}; allowed: {ends}")
    square = micrometres * micrometres
    return float((1 + sum(B * square / (square - C) for B, C in terms)) ** 0.5)
