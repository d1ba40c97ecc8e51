"""The curl of the field of light's directions before a sheet."""

import numpy as np
import pytest

from povgen import Bundle, Chess
from povgen.optics import equations


def curl_of_lines(scene, P, t, step=1e-4):
    """Return the curl of the directions of light, and the light's direction, and its place, by finite differences.

    The light comes from (0, 0, 2) through the point P of the window. The place is the length t behind the window. x, y
    and z are as the eye sees them, but z points to the eye, so that the coordinates are right-handed.
    """
    points = P + step * np.array([0, 1, -1, 1j, -1j])
    start = np.array([0, 0, 2.0])
    light = scene.trace(Bundle(start, np.column_stack((points.real, points.imag, 0 * points.real)) - start))
    assert light.designed.all()
    direction = light.direction * (1, 1, -1)
    place = np.column_stack((light.at(0).real, light.at(0).imag, 0 * points.real)) + t * direction
    moved = [(at[1] - at[2], at[3] - at[4]) for at in (place, direction)]
    to_place = np.linalg.inv(np.column_stack((*moved[0], direction[0])))
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = np.column_stack((*moved[1], 0 * direction[0])) @ to_place
    return np.array([zy - yz, xz - zx, yx - xy]), direction[0], place[0]


@pytest.mark.parametrize("alpha", [0, 66, 180, -120])
@pytest.mark.parametrize(("P", "t"), [(0.0, 0.0), (0.7 - 0.3j, 0.5)])
def test_the_curl_of_the_ray_trace_is_the_formulas(alpha, P, t):
    curl, direction, place = curl_of_lines(Chess(sheet="ideal", alpha=alpha), P, t)
    expected = equations.curl(2, place[2], np.radians(alpha), np.arccos(direction[2]))
    np.testing.assert_allclose(curl, expected * direction, atol=1e-6)
    assert (abs(expected) < 1e-12) == (alpha in (0, 180))  # only there light can have wave fronts


def test_the_curl_behind_several_windows():
    scene = Chess(sheet="ideal", alpha=50, window="alpha=-20,z=1", z1=1)
    curl, direction, place = curl_of_lines(scene.replace(window="alpha=-20,z=1"), 0.2j, 1.5)
    expected = equations.curl(1, place[2], np.radians(50), np.arccos(direction[2]), [(1, np.radians(-20))])
    np.testing.assert_allclose(curl, expected * direction, atol=1e-6)
