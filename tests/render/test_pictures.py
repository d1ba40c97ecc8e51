"""Pictures by real POV-Ray, compared with the equations. Positions are in tiles, in the plane z = 0."""

import base64
import re
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
from povgen.scene.model import APERTURE, VIEW
from povgen.video import overlay, still

WIDTH, HEIGHT = SIZE = 240, 180
TILES = VIEW / HEIGHT  # a pixel, in tiles
X, Y = np.meshgrid((np.arange(WIDTH) + 0.5 - WIDTH / 2) * TILES, (HEIGHT / 2 - np.arange(HEIGHT) - 0.5) * TILES)
HALF = APERTURE / 2
FLOOR = Chess().floor_y
FOOT = Chess().L.imag
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


@pytest.fixture(scope="module")
def sky(tmp_path_factory):
    """A picture of surroundings that are white above the horizon and black below it."""
    file = tmp_path_factory.mktemp("sky") / "halves.png"
    Image.fromarray(np.repeat([[255], [0]], 64, axis=0).astype(np.uint8).repeat(256, axis=1)).save(file)
    return file


def horizon(image):
    """Return the angle of the horizon, degrees counter-clockwise; the sky is on its left.

    It is the line through the window's centre with the greatest step in brightness between two narrow strips beside it.
    """
    blue = image[..., 2]
    near = np.hypot(X, Y) < 0.9 * HALF
    angles = np.arange(-180, 180, 0.25)

    def step(angle):
        away = Y * np.cos(np.radians(angle)) - X * np.sin(np.radians(angle))
        strip = near & (abs(away) < 0.3)
        return blue[strip & (away > 0)].mean() - blue[strip & (away < 0)].mean()

    return angles[np.argmax([step(angle) for angle in angles])]


def angle_between(a, b):
    return (a - b + 180) % 360 - 180


@pytest.mark.parametrize(
    ("x", "height"),
    some([(1, 5), (1.5, 1e-6), (0, 1.33), (0, 0.03)], 2, several=True),
)
def test_ideal_sheet_at_alpha_0_changes_nothing(x, height):
    scene = Chess(alpha=0, sheet="ideal", x=x, eye=(0, FLOOR + height))
    ideal, none = picture(scene), picture(scene.model_copy(update={"sheet": "none"}))
    differ = (abs(ideal - none).max(axis=-1) > 2).mean()  # more than rounding, 1 for each picture
    # rays that meet an edge exactly, or to within what interpolation costs off the axis; a shift by a pixel: 0.1 to 0.3
    assert differ < 0.02


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
    """A view that is stated stays, also that of a picture's record."""
    spheres = Spheres(z1=9, line=(0, 0), sheet="ideal", background="white")
    room = Room([Window(sheet="ideal", width=4)], background="white")
    for scene in (spheres, room):
        frame = (render(scene, size=(54, 96), antialias="off") < 250).any(-1)
        columns = np.flatnonzero(frame.any(0))
        assert 0 < columns[0] < 8 and 45 < columns[-1] < 53
    stated = [spheres.replace(view=VIEW), room.replace(eye=Eye(view=5))]
    assert fitted(stated, (54, 96)) == stated
    assert fitted([spheres, spheres.replace(eye=(-6, 3), z2=0.7)], (54, 96))[0].view > 10  # the scale of both


@pytest.mark.parametrize(
    "values",
    some(
        [{"sheet": "ideal", "window": "alpha=40,z=3"}, *({"sheet": sheet} for sheet in ("none", "ideal", "detailed"))],
        1,
    ),
)
def test_half_the_view_is_the_middle_of_the_picture(values):
    """Its pixels are those of the middle, for an eye anywhere. The window reaches all its edges."""
    scene = Chess(eye=(0.4, -0.3), **values)
    whole, half = (
        render(scene.model_copy(update={"view": view}), size=size, antialias="off").astype(int)
        for view, size in ((VIEW, SIZE), (VIEW / 2, (WIDTH // 2, HEIGHT // 2)))
    )
    middle = whole[HEIGHT // 4 : 3 * HEIGHT // 4, WIDTH // 4 : 3 * WIDTH // 4]
    differ = abs(half - middle).max(axis=-1) > 2
    assert differ.mean() < 0.012
    assert np.concatenate((differ[0], differ[:, -1])).mean() < 0.03  # POV-Ray's mesh camera would be half a pixel off


@pytest.mark.parametrize("alpha", some([66, 150, -50, 30, 110, 180], 2))
def test_ideal_sheet_shows_a_sphere_where_eq_7_says(alpha):
    scene = Spheres(alpha=alpha, sheet="ideal", z1=3, line=(-0.5, 0.3))
    image = picture(scene, "2,0.1,3")
    mask = yellow(image)
    seen = complex(X[mask].mean(), Y[mask].mean())
    P = equations.apparent_position(scene.L, scene.E, 3, scene.z2, radians(alpha))
    assert abs(seen - P) < 0.5 * TILES  # its shaded side counts for less


@pytest.mark.parametrize("alpha", some([66, -60, 25, 120, 180], 1))
@pytest.mark.parametrize("prisms", some([100, 400], 1))
def test_prisms_show_the_sphere_at_the_ideal_place(alpha, prisms):
    values = {"alpha": alpha, "z1": 3, "line": (-0.5, 0.3)}
    ideal = picture(Spheres(sheet="ideal", **values))
    real = picture(Spheres(prisms=prisms, **values), "1,0.3,2")
    # the shift is of the order of the sheets' thickness: 0.26 tiles at 100 prisms, seen at an angle of up to 0.5
    assert abs(place(real, yellow(real)) - place(ideal, yellow(ideal))) < 0.13 * 100 / prisms + 2 * TILES


def test_prisms_of_slightly_different_heights_show_the_piece_at_the_same_place():
    """With all that a scene declares, names of which the sheets must not use."""
    plan, built = (Chess(prisms=100, alpha=40, error=error) for error in ({}, {"pitches": 0.02}))
    places = [place(image, brown(image)) for image in map(picture, (plan, built))]
    assert abs(places[0] - places[1]) < 2 * TILES


@pytest.mark.parametrize(("sheet", "tolerance"), [("ideal", 0.75), ("detailed", 2)])
@pytest.mark.parametrize("alpha", some([66, -135, -45, 30, 90, 150, 180], 1))
def test_the_horizon_turns_by_alpha_counter_clockwise(sheet, tolerance, alpha, sky):
    scene = Spheres(alpha=alpha, sheet=sheet, z1=100, line=(9, 9), sky=sky)  # the sphere is out of the window
    assert abs(angle_between(horizon(picture(scene)), alpha)) < tolerance


def test_a_single_sheet_mirrors(sky):
    """It keeps the x component of light's direction and reverses the y component: the horizon is upside down."""
    scene = Spheres(sheet="single", z1=100, line=(9, 9), sky=sky)
    assert abs(angle_between(horizon(picture(scene)), 180)) < 2
    # at z1 = 1 the light of L = (X, Y) crosses the sheet at (X z2/(z2 + z1), Y z2/(z2 - z1))
    scene = Spheres(sheet="single", z1=1, line=(-0.5, 0.5), prisms=400)
    image = picture(scene)
    assert abs(place(image, yellow(image)) - complex(-0.5 * 6 / 7, 0.5 * 6 / 5)) < 0.05


@pytest.mark.parametrize("alpha", some([50, 0, 90, 135, 180, -90], 2))
@pytest.mark.parametrize("prisms", some([30, 100], 1))
def test_the_near_sheet_fills_the_window_and_stays_in_its_frame(alpha, prisms, tmp_path):
    """With glowing red glass and no far sheet, the window is red to its corners, and nothing else is red."""
    scene = Chess(alpha=alpha, prisms=prisms, z1=3)
    (macro,) = re.findall(r"^#macro Sheet\(.*?^#end$", to_pov(scene), flags=re.M | re.S)
    only_near = """
#declare GlassTexture = texture { pigment { rgb x } finish { ambient 0 emission 1 } }
#declare Nothing = sphere { 0, 0 }
#macro Sheet(Angle, Centre) #if (Centre < 0) OwnSheet(Angle, Centre) #else Nothing #end #end
"""
    text = to_pov(scene, sheet_macro=macro.replace("Sheet", "OwnSheet", 1) + only_near)
    image = frames.read_png(povray.run(text, Rendering(size=SIZE, antialias="off"), tmp_path)).astype(int)
    red = image[..., 0] > 100 + image[..., 1]  # glowing glass is (255, 0, 0); the rest is brown, grey or blue
    inside = (abs(X) < HALF) & (abs(Y) < HALF)
    corners = inside & (abs(X) > HALF - 0.2) & (abs(Y) > HALF - 0.2)
    # one gap between prisms is seen edge-on by the eye
    assert red[inside].mean() > 0.99 and red[corners].mean() > 0.94
    # the frame's front, half its depth before z = 0, appears a little larger
    outside = HALF * 6 / (6 - Chess(prisms=prisms, z1=3).depth / 2) + TILES
    assert not red[(abs(X) > outside) | (abs(Y) > outside)].any()


@pytest.mark.parametrize("sheet", ["ideal", "detailed"])
@pytest.mark.parametrize("alpha", some([66, 0, 120], 1))
def test_the_predicted_image_lies_on_the_piece(alpha, sheet):
    scene = Chess(alpha=alpha, sheet=sheet, prisms=400, z1=2, x=0.2)
    without, predicted = picture(scene), picture(scene.model_copy(update={"predicted_image": True}))
    drawn = Image.fromarray((abs(predicted - without).max(axis=-1) > 8).astype(np.uint8)).copy()
    line = np.array(drawn, bool)
    ImageDraw.floodfill(drawn, (0, 0), 2)
    enclosed = np.array(drawn) == 0
    assert line.sum() < enclosed.sum()  # an outline, which leaves the piece as it is
    piece = brown(picture(scene.model_copy(update={"sheet": "ideal"})))
    overlap = (enclosed & piece).sum() / ((enclosed | piece) & ~line).sum()
    assert overlap > 0.8  # the outline is flat, and right for the piece's axis


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


def test_every_piece_is_different_and_stands_on_its_pedestal():
    shapes = {}
    for piece in ("pawn", "rook", "knight", "bishop", "queen", "king"):
        image = picture(Chess(sheet="none", piece=piece))
        mask = brown(image)
        assert abs(Y[mask].min() - FOOT * 6 / (6 + 1.6)) < 0.06  # the foot's nearest point is at z1 = 1.6
        shapes[piece] = mask
    for a in shapes:
        for b in shapes:
            assert a == b or (shapes[a] ^ shapes[b]).sum() > 0.05 * (shapes[a] | shapes[b]).sum(), (a, b)


def test_a_scene_shows_itself_in_a_notebook():
    shell = InteractiveShell.instance()
    povgen._shown_in_notebooks()
    (data, _) = shell.display_formatter.format(Spheres(sheet="none", z1=2))
    InteractiveShell.clear_instance()
    data = base64.b64decode(data["image/png"]) if isinstance(data["image/png"], str) else data["image/png"]
    assert data.startswith(b"\x89PNG") and data == still.as_file(Spheres(sheet="none", z1=2), Rendering())
