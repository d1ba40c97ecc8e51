"""The field of light's directions before a sheet: its curl, and the wave fronts that prisms make instead."""

import numpy as np
import pytest
import ray_field as field

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


def test_prisms_have_the_curl_as_a_mean_and_none_in_each_of_them():
    scene = Chess(alpha=66, prisms=300)
    whole = field.light_of(scene, 0.3, 3000)
    assert field.traced_curl(whole, 1.0) == pytest.approx(equations.curl(2, 1, np.radians(66)), abs=0.02)
    assert whole.convergence().rms > 0.1
    rays, pitch = scene.pencil((0, 0, 2), 100, radius=0.3), scene.prism.pitch
    middle = rays.at(0)[scene.trace(rays).designed][0]
    light = scene.trace(scene.pencil((0, 0, 2), 200, middle=middle, radius=0.02 * pitch))
    piece, spread = light.convergence(), np.std(light.slope)
    assert light.designed.all() and piece.z == pytest.approx(2, abs=5 * pitch)  # an image of the point
    assert piece.rms < 0.03 * spread and whole.convergence().rms > np.std(whole.slope)


def test_wave_fronts_of_prisms_jump_and_those_demanded_do_not_close():
    turns = np.linspace(0, 2 * np.pi, 20001)
    Q = field.RADIUS * np.exp(1j * turns)
    path = field.path_through_prisms(Q)
    steps = np.diff(path)
    jumps = abs(steps) > 1e-7
    gap = np.pi * field.RADIUS**2 * equations.curl(1, 0, np.radians(66))
    assert path[0] == pytest.approx(path[-1])  # the jumps make good what is missing
    assert steps[~jumps].sum() == pytest.approx(gap, rel=0.03) == -steps[jumps].sum()
    # the direction of light in the middle of a prism is that of the ideal sheet
    at = field.PITCH * (3 * np.exp(0.5j * np.radians(66)) - 2j * 0) / np.cos(np.radians(33))
    rates = [(field.path_through_prisms(at + d) - field.path_through_prisms(at - d)) / 2e-9 for d in (1e-9, 1e-9j)]
    assert abs(complex(*rates) - at * np.exp(1j * np.radians(66))) < field.PITCH
