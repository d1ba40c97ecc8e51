"""Pictures by real POV-Ray, compared with the equations. Positions are in tiles, in the plane z = 0."""

import base64
from math import radians

import numpy as np
import pytest
from conftest import some
from IPython.core.interactiveshell import InteractiveShell
from PIL import Image, ImageDraw

import povgen
from povgen import Chess, Eye, Rendering, Room, Spheres, Window, render, to_pov
from povgen.optics import equations
from povgen.rendering import frames, povray
from povgen.rendering.views import fitted
from povgen.scene import camera
from povgen.scene.eye_and_windows import APERTURE, VIEW
from povgen.video import overlay, still

WIDTH, HEIGHT = SIZE = 240, 180
TILES = VIEW / HEIGHT  # a pixel, in tiles
X, Y = np.meshgrid((np.arange(WIDTH) + 0.5 - WIDTH / 2) * TILES, (HEIGHT / 2 - np.arange(HEIGHT) - 0.5) * TILES)
HALF = APERTURE / 2
FLOOR = Chess().floor_y
INSIDE = (abs(X) < HALF - 0.05) & (abs(Y) < HALF - 0.05)  # clear of the frame's inner walls


def picture(scene, antialias="off"):
    return render(scene, size=SIZE, antialias=antialias).astype(float)


def place(image, mask):
    """Return the median position of a coloured object. The median ignores the scraps that stray light makes."""
    assert mask.sum() > 15, "the object is not visible"
    return complex(np.median(X[mask]), np.median(Y[mask]))


def brown(image):
    # without the piece, no pixel is redder than blue by more than 26
    return INSIDE & (image[..., 0] > image[..., 2] + 50)


def yellow(image):
    # the scene of a single sphere: the sphere is yellow, also on its dark side; the frame is redder
    red, green, blue = np.moveaxis(image, -1, 0)
    return INSIDE & (green > 0.75 * red) & (np.minimum(red, green) > 1.3 * blue + 10)


@pytest.mark.parametrize("alpha", some([66, 0, -120], 1))
@pytest.mark.parametrize(("x", "height"), some([(0.8, 0.01), (1.5, 1e-6), (0, 0.3), (0, 0.001)], 2, several=True))
def test_no_sky_below_the_horizon(x, height, alpha, tmp_path):
    """A ray that runs downwards meets the floor, the piece or the window frame, however low the eye is."""
    scene = Chess(sheet="ideal", alpha=alpha, x=x, eye=(0, FLOOR + height))
    text = to_pov(scene) + "sky_sphere { pigment { rgb z } }\n"  # pure blue; POV-Ray takes the last sky
    image = frames.read_png(povray.run(text, Rendering(size=SIZE, antialias="off"), tmp_path)).astype(int)
    sky = image[..., 2] > image[..., 0] + 150
    inside, direction = camera.rays(scene, SIZE)
    down = Y < scene.E.imag
    down[inside] = equations.rotate(direction, radians(alpha))[:, 1] < -0.01
    assert down.sum() > 2000 and sky.any() and not (sky & down).any()


@pytest.mark.parametrize(
    "values",
    [
        {"prisms": 12},
        {"prisms": 1, "z2": 20, "z1": 20},
        {"sheet": "ideal", "z2": 0.7, "eye": (-6, 3)},
    ],
)
def test_a_default_view_shows_the_whole_frame(values):
    """The frame nearly fills the picture, and the sky is all round it."""
    scene = Spheres(**{"z1": 9, "line": (0, 0), "background": "white", **values})
    assert scene.view > VIEW and scene.replace(view=VIEW).view == VIEW
    frame = (render(scene, size=(128, 96), antialias="off") < 250).any(-1)
    rows, columns = (np.flatnonzero(frame.any(axis)) for axis in (1, 0))
    assert rows[0] > 0 and rows[-1] < 95 and columns[0] > 0 and columns[-1] < 127
    margins = rows[0], 95 - rows[-1], columns[0], 127 - columns[-1]
    assert min(margins) <= 3


def test_a_narrow_picture_shows_the_whole_frame():
    """So do its text, rays and points. A view that is stated stays, also that of a picture's record."""
    size = 54, 96
    spheres = Spheres(z1=9, line=(0, 0), sheet="ideal", background="white")
    room = Room([Window(sheet="ideal", width=4)], background="white")
    for scene in (spheres, room):
        frame = (render(scene, size=size, antialias="off") < 250).any(-1)
        columns = np.flatnonzero(frame.any(0))
        assert 0 < columns[0] < 8 and 45 < columns[-1] < 53
        shown = scene.fitted(size)
        assert shown.camera.height > scene.camera.height and to_pov(scene, size=size) == to_pov(shown, size=size)
        assert (scene.rays(size).direction == shown.rays(size).direction).all()
        np.testing.assert_array_equal(povgen.points(scene, size), povgen.points(shown, size))
    stated = [spheres.replace(view=VIEW), room.replace(eye=Eye(view=5))]
    assert fitted(stated, size) == stated
    assert fitted([spheres, spheres.replace(eye=(-6, 3), z2=0.7)], size)[0].view > 10  # the scale of both


@pytest.mark.parametrize("alpha", some([66, 150, -50, 30, 110, 180], 2))
def test_ideal_sheet_shows_a_sphere_where_eq_7_says(alpha):
    scene = Spheres(alpha=alpha, sheet="ideal", z1=3, line=(-0.5, 0.3))
    image = picture(scene, "2,0.1,3")
    mask = yellow(image)
    seen = complex(X[mask].mean(), Y[mask].mean())
    P = equations.apparent_position(scene.L, scene.E, 3, scene.z2, radians(alpha))
    assert abs(seen - P) < 0.5 * TILES  # its shaded side counts for less


def test_prisms_of_slightly_different_heights_show_the_piece_at_the_same_place():
    """With all that a scene declares, names of which the sheets must not use."""
    plan, built = (Chess(prisms=100, alpha=40, error=error) for error in ({}, {"pitches": 0.02}))
    places = [place(image, brown(image)) for image in map(picture, (plan, built))]
    assert abs(places[0] - places[1]) < 2 * TILES


@pytest.mark.parametrize(
    ("scene", "distance"), [(Chess(alpha=120, sheet="mirror", z1=4), 4), (Chess(z1=3, window=[{"z": 2}]), 5)]
)
def test_the_direct_image_lies_on_the_piece_without_sheets(scene, distance):
    grey = np.full((HEIGHT, WIDTH, 3), 128, np.uint8)
    line = overlay.annotated(grey, scene.replace(direct_image=True), Rendering(size=SIZE))[..., 0] != 128
    inside = Image.fromarray(line.astype(np.uint8)).copy()
    ImageDraw.floodfill(inside, (0, 0), 2)
    enclosed, piece = np.array(inside) == 0, brown(picture(Chess(sheet="none", z1=distance)))
    assert (enclosed & piece).sum() > 0.8 * ((enclosed | piece) & ~line).sum()


def test_a_scene_shows_itself_in_a_notebook():
    shell = InteractiveShell.instance()
    povgen._shown_in_notebooks()
    (data, _) = shell.display_formatter.format(Spheres(sheet="none", z1=2))
    InteractiveShell.clear_instance()
    data = base64.b64decode(data["image/png"]) if isinstance(data["image/png"], str) else data["image/png"]
    assert data.startswith(b"\x89PNG") and data == still.as_file(Spheres(sheet="none", z1=2), Rendering())
