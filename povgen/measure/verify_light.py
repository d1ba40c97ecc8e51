"""How bright the window is: black tops of prisms, and partial reflection."""

from collections.abc import Iterator
from math import radians

import numpy as np

from povgen import limits
from povgen.measure import probes
from povgen.measure.measured import SMALL, Measured
from povgen.measure.probes import Directions, Light, Size, White
from povgen.optics import equations
from povgen.optics.faces import Face
from povgen.optics.polarisation import jones, mean_transmission, transmission
from povgen.optics.trace import End
from povgen.scene import camera, survey
from povgen.scene.scenes import APERTURE, VIEW


def black_tops(size: Size = SMALL) -> Iterator[Measured]:
    """Compare which pixels are black, if the tops of prisms are, with the exact ray trace."""
    scene = Directions(sheet="detailed", tops="black", aperture=APERTURE, view=VIEW)
    (decoded,) = probes.decoded([scene], size)
    inside, direction = camera.rays(scene, size)
    found = scene.trace(camera.along(scene, direction), survey.max_trace_level(scene))
    seen = (found.end <= End.BACK) & (found.count < survey.max_trace_level(scene))
    black = (found.faces == Face.TOP).any(1)
    agree = np.isnan(decoded[inside][seen][:, 0]) == black[seen]
    what = f"black tops take {100 * black[seen].mean():.1f} % of the pixels: as in the ray trace"
    yield Measured("detailed", what, 100 * agree.mean(), 99.5, "%", least=True)


def partial_reflection(size: Size = SMALL) -> Iterator[Measured]:
    """Compare the brightness of light on the designed path with the Fresnel equations, if faces also reflect light."""
    scene = Light(sheet="detailed", fresnel=True, z1=2, L=0.3 + 0.1j, extent=0.25)
    inside, direction = camera.rays(scene, size)
    angles, prism = [0, radians(scene.alpha) / 2], scene.prism
    light = -equations.rotate(direction, radians(scene.alpha))  # towards the eye, before the sheets
    clear = probes.brightness(scene.replace(fresnel=False), size)[inside] > 0.99
    clear &= scene.trace(camera.along(scene, direction)).designed
    seen = probes.brightness(scene, size)[inside][clear]
    expected = mean_transmission(light[clear], angles, prism)
    off = np.quantile(abs(seen - expected), 0.99)
    what = f"--fresnel: brightness on the designed path ({seen.mean():.3f}) against Fresnel's equations, 99 % of pixels"
    yield Measured("detailed", what, off, 0.0005)
    both = transmission(jones(light[clear], angles, prism)).mean()
    what = f"--fresnel: its mean against that of polarised light ({both:.3f})"
    yield Measured("detailed", what, abs(seen.mean() - both), 0.02)


def reflected_light(size: Size = SMALL) -> Iterator[Measured]:
    """Compare the window's mean brightness with the ray trace, for partial reflection and white surroundings.

    The ray trace also says what share of this light has been partially reflected at least once.
    """
    for sheet, z2 in (("detailed", 6), ("single", 60)):
        scene = White(sheet=sheet, z2=z2, fresnel=True, aperture=APERTURE, view=VIEW)
        inside, direction = camera.rays(scene, size)
        seen = probes.brightness(scene, size)[inside].mean()
        directions = np.tile(direction, (100_000 // len(direction) + 1, 1))
        # through more faces than POV-Ray follows: its max_trace_level should cost no light
        most = 2 * limits.MAX_FACES
        found = scene.trace(camera.along(scene, directions), most, partial=np.random.default_rng(1))
        followed = (found.end <= End.BACK) & (found.light >= limits.LEAST_LIGHT)
        share = 100 * found.reflected[followed].mean()
        what = f"--fresnel, z2 = {z2}: brightness of the window ({seen:.3f}, {share:.1f} % reflected), ray trace"
        yield Measured(sheet, what, abs(seen - followed.mean()), 0.005)
