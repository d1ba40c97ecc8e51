"""Materials, light and sky, for POV-Ray (templates/*.pov.j2) and for the live view (povgen/liveview/*.glsl) alike.

Colours are red, green and blue: linear light, 0 to 1. Numbers are text, as the scene's text shows them. Formulas are in
POV-Ray's language; `floats` makes GLSL of them. Lengths are in tiles.
"""

import re
from collections.abc import Mapping
from itertools import pairwise

# Values of a pattern, 0 to 1, and the colour at each. Between two values the colour is interpolated.
COLOUR_MAPS = {
    "LightTile": {"0.00": "0.58, 0.50, 0.40", "0.06": "0.76, 0.71, 0.61", "1.00": "0.82, 0.78, 0.69"},
    "DarkTile": {"0.00": "0.20, 0.25, 0.23", "0.06": "0.085, 0.125, 0.115", "1.00": "0.055, 0.085, 0.078"},
    "Frame": {"0": "0.080, 0.032, 0.015", "1": "0.160, 0.066, 0.028"},
    "FurtherFrame": {"0": "0.020, 0.050, 0.085", "1": "0.040, 0.100, 0.165"},  # of the windows behind the first
    "Plinth": {"0": "0.86, 0.82, 0.75", "0.08": "0.58, 0.53, 0.46", "1": "0.54, 0.49, 0.42"},  # limestone
    "SphereColor": {
        "0.00": "1.00, 0.74, 0.00",
        "0.30": "0.95, 0.24, 0.01",
        "0.55": "0.75, 0.02, 0.03",
        "0.78": "0.45, 0.01, 0.28",
        "1.00": "0.08, 0.01, 0.22",
    },
    "SkyPigment": {
        "0.00": "0.72, 0.83, 0.92",
        "0.08": "0.46, 0.66, 0.88",
        "0.33": "0.16, 0.36, 0.70",
        "0.71": "0.05, 0.16, 0.44",
    },
    "PlainPigment": {
        "0": "0.66, 0.74, 0.80",
        "0.06": "0.36, 0.42, 0.42",
        "0.2": "0.18, 0.21, 0.19",
        "1": "0.08, 0.09, 0.08",
    },
}
LIP = "0.85, 0.58, 0.22"  # the metal at the frame's opening
CARD_BACK = "0.55, 0.52, 0.48"  # the back and the edges of a board with a picture
# Late wood, 0, is thin and dark; early wood, 1, is wide and light. Factors of the piece's colour, sRGB
WOOD = {"0": "0.78, 0.66, 0.54", "0.5": "0.93, 0.88, 0.82", "1": "1"}

# ambient, diffuse, specular, roughness
FINISHES = {
    "floor": ("0.05", "0.72", "0.15", "0.03"),
    "frame": ("0.05", "0.8", "0.5", "0.02"),
    "lip": ("0.05", "0.55", "0.8", "0.04"),
    "plinth": ("0.05", "0.75", "0.2", "0.03"),
    "wood": ("0.05", "0.78", "0.7", "0.008"),
    "card": ("0.05", "0.75", "0", "0.05"),
    "sphere": ("0.05", "0.75", "0.5", "0.02"),
}

# x, y and z are a point's.
FORMULAS = {
    "StoneVein(x, y, z)": "abs(sin(1.3*x + 0.9*z + 1.9*sin(0.9*z - 0.5*x) + 0.9*sin(2.3*x + 1.7*z)"
    " + 0.35*sin(5.3*z - 4.1*x) + 0.15*sin(13*x + 9*z)))",
    "Fibres(x, y, z)": "0.5 + 0.5*sin(90*y + 60*z + 1.5*sin(2.1*x + 3*y) + 0.7*sin(5.3*x))",
    "PlinthVein(x, y, z)": "abs(sin(1.9*x + 2.3*y + 1.7*z + 1.9*sin(1.3*y - 1.9*x) + 0.7*sin(4*x + 3*z - 3*y)"
    " + 0.2*sin(17*x + 13*y)))",
    "PlinthBase(Pedestal)": "min(0.10, 0.4*Pedestal)",
    "PlinthCap(Pedestal)": "min(0.08, 0.3*Pedestal)",
    "PlinthShaft(H)": "0.88*H",
    "TrunkX(x, y, z)": "x - 1.45 + 0.16*sin(1.3*y) + 0.03*sin(5.1*y + 4*z)",
    "TrunkZ(y, z)": "z - 0.9 - 0.12*sin(1.9*y + 1)",
    "Growth(R)": "2*pi*10*R + 1.3*sin(2*pi*1.7*R)",
    "Late(G)": "pow(max(0, 0.5 + 0.5*sin(G + 0.8*sin(G))), 3)",
    "Rings(x, y, z)": "0.95 - 0.85*Late(Growth(Trunk(x, y, z)))"
    " + 0.05*sin(150*x + 5*sin(1.3*y))*sin(130*z + 4*sin(1.7*y))",
}

# The sun is low, but high enough that the frame's shadow does not fall on a piece at z1 = 2. It is a row of as many
# point lights as `lights` says. `row` is the vector along the row, and `direction` points to the sun.
SUN = {"direction": "-1000, 640, -400", "colour": "1.75, 1.42, 1.00", "row": "70, 50, 20", "lights": 7}
# These two cast no shadows. The floor sends some of the sun's light upwards.
SKY_LIGHT = {"direction": "100, 1200, -300", "colour": "0.13, 0.19, 0.29"}
FLOOR_LIGHT = {"direction": "800, -150, -700", "colour": "0.13, 0.11, 0.085"}
# With distance, the floor's pattern fades into haze. `colour` is the haze's pigment: lit by SUN and SKY_LIGHT, it has
# the colour of the mountains' lower ends. The nearness of a point is 1 - d/`distance`, with its distance d from the
# point of the floor below the window's centre. The pattern is absent at the nearness `gone`, and full at `whole`.
FADE = {"distance": "120", "colour": "0.842, 1.050, 1.291", "gone": "0.1", "whole": "0.9"}
# Rows of the panorama of mountains (docs/mountains.py) go from the sine `low` of the angle above the horizon to `high`.
# It is shown up to the sine `whole`, and fades into the sky up to `gone`.
PANORAMA = {"low": "-0.01", "high": "0.5", "whole": "0.35", "gone": "0.45"}


def finish(name: str) -> str:
    """Return what stands in the braces of POV-Ray's `finish`."""
    return "ambient {} diffuse {} specular {} roughness {}".format(*FINISHES[name])


def color_map(name: str) -> str:
    """Return what stands in the braces of POV-Ray's `color_map`."""
    return " ".join(f"[{place} rgb <{colour}>]" for place, colour in COLOUR_MAPS[name].items())


def floats(formula: str) -> str:
    """Return a formula in GLSL: a whole number such as 2 becomes 2.0, because GLSL needs floating-point numbers."""
    return re.sub(r"(?<![\w.])(?<!e-)\d+(?![\w.])", r"\g<0>.0", formula)


def interpolated(colours: Mapping[str, str], wanted: str = "vec3({})") -> str:
    """Return the colour of a colour map as a GLSL expression of the variable `value`.

    `wanted` is the GLSL expression for one colour, in which {} stands for the colour's numbers.
    """
    found = wanted.format(next(iter(colours.values())))
    for before, place in pairwise(colours):
        share = floats(f"clamp((value - {before})/({place} - {before}), 0, 1)")
        found = f"mix({found}, {wanted.format(colours[place])}, {share})"
    return found
