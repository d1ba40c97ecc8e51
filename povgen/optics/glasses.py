"""Refractive indices of glasses, plastics and water, at 20 degrees C (CaF2 24) in air, from dispersion formulas.

All formulas are Sellmeier's: n^2 - 1 = sum of B w^2/(w^2 - C), with the wavelength w in micrometres. The glasses are
Schott's (catalogue of 2017-01-20). A glass N-... replaces an older one with lead or arsenic, whose name lacks the N-.
They are different glasses, such as N-SF11 and SF11. But for BK7 Schott stated the same formula as for N-BK7.
fused-silica: Malitson, J. Opt. Soc. Am. 55, 1205 (1965). CaF2: Malitson, Appl. Opt. 2, 1103 (1963). PMMA and
polycarbonate: measured by Sultanova, Kasarova and Nikolov, Acta Phys. Pol. A 116, 585 (2009), formula fitted by the
refractiveindex.info database. water: Daimon and Masumura, Appl. Opt. 46, 3811 (2007); against vacuum, which is 0.0004
more than against air.
"""

from difflib import get_close_matches
from math import inf
from numbers import Real
from typing import NamedTuple


class Glass(NamedTuple):
    """A glass: the formula's coefficients, and the wavelengths for which it holds."""

    range: tuple[float, float]  # micrometres
    terms: tuple[tuple[float, float], ...]  # B, and C in square micrometres


_BK7 = Glass((0.3, 2.5), ((1.03961212, 0.00600069867), (0.231792344, 0.0200179144), (1.01046945, 103.560653)))
GLASSES = {
    "BK7": _BK7,
    "N-BK7": _BK7,
    "N-K5": Glass((0.31, 2.5), ((1.08511833, 0.00661099503), (0.199562005, 0.024110866), (0.930511663, 111.982777))),
    "N-FK51A": Glass(
        (0.29, 2.5), ((0.971247817, 0.00472301995), (0.216901417, 0.0153575612), (0.904651666, 168.68133))
    ),
    "N-BAK4": Glass(
        (0.334, 2.5), ((1.28834642, 0.00779980626), (0.132817724, 0.0315631177), (0.945395373, 105.965875))
    ),
    "N-SK16": Glass((0.31, 2.5), ((1.34317774, 0.00704687339), (0.241144399, 0.0229005), (0.994317969, 92.7508526))),
    "F2": Glass((0.32, 2.5), ((1.34533359, 0.00997743871), (0.209073176, 0.0470450767), (0.937357162, 111.886764))),
    "N-F2": Glass((0.365, 2.5), ((1.39757037, 0.00995906143), (0.159201403, 0.0546931752), (1.2686543, 119.248346))),
    "SF5": Glass((0.35, 2.5), ((1.46141885, 0.0111826126), (0.247713019, 0.0508594669), (0.949995832, 112.041888))),
    "N-SF5": Glass((0.37, 2.5), ((1.52481889, 0.011254756), (0.187085527, 0.0588995392), (1.42729015, 129.141675))),
    "N-BAF10": Glass((0.35, 2.5), ((1.5851495, 0.00926681282), (0.143559385, 0.0424489805), (1.08521269, 105.613573))),
    "N-LAK8": Glass((0.31, 2.5), ((1.33183167, 0.00620023871), (0.546623206, 0.0216465439), (1.19084015, 82.5827736))),
    "SF10": Glass((0.38, 2.5), ((1.61625977, 0.0127534559), (0.259229334, 0.0581983954), (1.07762317, 116.60768))),
    "N-SF10": Glass((0.38, 2.5), ((1.62153902, 0.0122241457), (0.256287842, 0.0595736775), (1.64447552, 147.468793))),
    "SF11": Glass((0.39, 2.5), ((1.73848403, 0.0136068604), (0.311168974, 0.0615960463), (1.17490871, 121.922711))),
    "N-SF11": Glass((0.37, 2.5), ((1.73759695, 0.013188707), (0.313747346, 0.0623068142), (1.89878101, 155.23629))),
    "SF6": Glass((0.365, 2.5), ((1.72448482, 0.0134871947), (0.390104889, 0.0569318095), (1.04572858, 118.557185))),
    "N-SF6": Glass((0.37, 2.5), ((1.77931763, 0.0133714182), (0.338149866, 0.0617533621), (2.08734474, 174.01759))),
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


def named(glass: object) -> str:
    """Return a glass's name as it is in `GLASSES`: upper and lower case, hyphens and spaces do not matter.

    Raises ValueError for an unknown name. The message has a known name that is near to it.
    """
    known = {_plain(name): name for name in GLASSES}
    plain = _plain(glass) if isinstance(glass, str) else ""
    if plain in known:
        return known[plain]
    near = get_close_matches(plain[:50], known, 1)  # a long text would need much memory
    raise ValueError(f"unknown; did you mean {known[near[0]]}?" if near else f"unknown; allowed: {', '.join(GLASSES)}")


def _plain(name: str) -> str:
    return name.lower().replace("-", "").replace(" ", "")


def index(glass: str, wavelength: float) -> float:
    """Return the refractive index n of a glass at a wavelength in metres, as all wavelengths in this package.

    Raises ValueError for an unknown glass (`named`), and for a wavelength at which the glass's formula does not hold.
    """
    try:
        name = named(glass)
    except ValueError as error:
        raise ValueError(f"glass = {_shown(glass)}: {error}") from None
    if isinstance(wavelength, bool) or not isinstance(wavelength, Real):
        raise ValueError(f"wavelength = {_shown(wavelength)}: allowed: one number, metres")
    try:
        micrometres = 1e6 * float(wavelength)
    except OverflowError:
        micrometres = inf
    (least, most), terms = GLASSES[name]
    if not (1 - 1e-9) * least <= micrometres <= (1 + 1e-9) * most:  # for rounding errors
        ends = f"{1000 * least:g} to {1000 * most:g} nm"
        raise ValueError(f"wavelength of {1000 * micrometres:g} nm: outside the formula of {name}; allowed: {ends}")
    square = micrometres * micrometres
    return float((1 + sum(B * square / (square - C) for B, C in terms)) ** 0.5)


def _shown(value: object) -> str:
    """Return a value as text for a message: one short line."""
    return f"{' '.join(repr(value).split()):.60}"
