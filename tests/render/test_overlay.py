"""Captions and overlays on blank pictures: the marks are where the equations say, and they cover nothing else."""

from itertools import pairwise
from math import radians

import numpy as np
import pytest

from povgen import Chess, InputError, Piece, Room, Spheres
from povgen.optics import equations
from povgen.rendering.views import views
from povgen.scene.eye_and_windows import VIEW
from povgen.settings import Rendering
from povgen.video import caption_strips, caption_texts, encode, overlay, side, still
from povgen.video.text import STRIP, TEXT, _font, _runs, text_width

BLANK = {size: np.full((size[1], size[0], 3), 120, np.uint8) for size in ((640, 480), (320, 240), (64, 48))}


def parts(scene, size=(640, 480), texts=None, **options):
    """Return what is drawn for a grey picture: the strip above it, the picture, and the strip below it."""
    made = overlay.annotated(BLANK[size], scene, Rendering(size=size, **options), texts).astype(int)
    top = np.argmin((made[:, 0] == STRIP).all(-1))
    return made[:top], made[top : top + size[1]], made[top + size[1] :]


def drawn(scene, size=(640, 480), **options):
    """Return what is drawn on a grey picture, without the strips above and below it."""
    return parts(scene, size, **options)[1]


def yellow(picture):
    """Return the points of the plane z = 0 at which marks are drawn."""
    red, green, blue = np.moveaxis(picture, -1, 0)
    place = Chess().camera.pixels(picture.shape[1::-1])
    return place[(red > 200) & (green > 190) & (blue < 110)]


@pytest.mark.parametrize("sheet", ["ideal", "detailed", "single", "none"])
@pytest.mark.parametrize("alpha, z1", [(66, 20), (-120, 9)])
def test_the_mark_is_where_the_piece_is_predicted(sheet, alpha, z1):
    scene = Chess(sheet=sheet, alpha=alpha, z1=z1, x=0.4, eye=(0, -0.6))
    marks = yellow(drawn(scene, overlay=True))
    pixel = scene.view / 480
    assert 45 < len(marks) < 70
    assert abs(marks.mean() - scene.apparent_position(scene.L, scene.z1)) < 0.3 * pixel


def test_every_sphere_has_its_mark_on_the_circle():
    scene = Spheres(alpha=90, z1=[1.5, 6, 24])
    marks = yellow(drawn(scene, overlay=True))
    ((line,), _), *others = overlay.loci(scene)
    assert not others  # no circle of constant r for each
    assert len(overlay.positions(scene)) == 3
    for place in overlay.positions(scene):
        assert abs(marks - place).min() < scene.view / 480 * 4
        assert abs(line - place).min() < 0.01
    ideal = Spheres(alpha=60, sheet="ideal", z1=[6])
    ((line,), _), (turned, _) = overlay.loci(ideal)
    # constant alpha: L and E are seen at one angle from everywhere; constant r: distances to them are in one ratio
    assert np.allclose(np.angle((line - ideal.E) / (ideal.L - line)), radians(60), atol=1e-9)
    turned = np.concatenate(turned)
    assert np.allclose(abs(turned - ideal.E) / abs(turned - ideal.L), 1)


def near(places, reach, size=(640, 480)):
    """Return a mask of the pixels that are within a reach (pixels) of one of the places."""
    mask = np.zeros(size[::-1], bool)
    tile = size[1] / VIEW
    x, y = size[0] / 2 + places.real * tile, size[1] / 2 - places.imag * tile
    mask[y.astype(int), x.astype(int)] = True
    grown = np.zeros_like(mask)
    steps = np.arange(-int(reach), int(reach) + 1)
    for dy, dx in ((dy, dx) for dy in steps for dx in steps if np.hypot(dx, dy) <= reach):
        grown |= np.roll(mask, (dy, dx), (0, 1))
    return grown


def dense(first, last, *about):
    """Return parameters between two ends. They are denser near values at which a curve may pass through infinity."""
    steps = np.geomspace(1e-12, 1, 60_000) * (last - first)
    found = np.concatenate([np.linspace(first, last, 200_000), *(at + s * steps for at in about for s in (-1, 1))])
    return found[(first < found) & (found < last)]


@pytest.mark.parametrize(
    "scene, z1, alphas",
    [
        # alpha changes: one branch of a hyperbola in the window, one beyond
        (Spheres(alpha=100, z1=[6], line=(0.1, 0.05)), 0, (180,)),
        # z1 changes: both branches in the window
        (Spheres(z1=[6], line=(0.1, 0.05), sheet="single"), 6, None),
        # a straight line through infinity, but not from L to E
        (Spheres(alpha=180, sheet="ideal"), 6, None),
        # the pole within a thousandth of a tile and of a degree, and all near the eye's axis
        (Spheres(alpha=180, z1=[6], line=(1e-3, 2e-3), prisms=3000), 6, (180,)),
    ],
)
def test_curves_are_whole_and_never_cross_infinity(scene, z1, alphas, monkeypatch):
    """Every visible point of the true curve is drawn. Nothing is drawn farther from it than the line is wide."""
    distances = dense(scene.depth / 2, 1e4 * scene.z2, scene.depth / 2, z1)
    true = [scene.seen(scene.L, distances)]
    if alphas:
        true.append(scene.seen(scene.L, scene.distances[0], dense(-180, 180, -180, *alphas)))
    places = np.concatenate([place[visible] for place, visible in true])
    monkeypatch.setattr(overlay, "positions", lambda scene: [])
    monkeypatch.setattr(overlay, "_named", lambda scene: {})
    changed = (drawn(scene, overlay=True) != 120).any(-1)
    assert changed.sum() > 500
    assert not (near(places, 0) & ~changed).any()
    assert not (changed & ~near(places, 1.1 * 480 / 180 + 1.5)).any()


@pytest.mark.parametrize(
    "scene",
    [
        Chess(alpha=150, prisms=20, pedestal=0),  # the foot is seen below the window
        Chess(sheet="none", z1=6, x=2.97, eye=(0, -0.33)),  # behind the frame's side, which is deep
        Spheres(sheet="none", z1=[1], z2=0.5, line=(-3.75, 0)),
    ],
)
def test_no_mark_where_the_frame_hides_the_object(scene):
    picture = drawn(scene, overlay=True)
    assert not len(yellow(picture)) and not overlay.positions(scene)
    assert overlay.P_COLOUR not in [colour for _, colour in overlay.legend(scene, Rendering(overlay=True))]
    drawn_at = scene.camera.pixels((640, 480))[(picture != 120).any(-1)]
    front = scene.E + (drawn_at - scene.E) * (1 - scene.depth / 2 / scene.z2)
    reach = np.maximum(abs(front.real), abs(front.imag)).max(initial=0)
    assert reach < scene.aperture / 2 + 4 * scene.view / 480  # half a line's width


def test_the_caption_prints_what_the_equations_predict():
    assert caption_texts.facts(Chess(alpha=66, sheet="ideal")) == {
        "alpha": "66°",
        "z1": "2 tiles",
        "z2": "6 tiles",
        "r": "3",
        "nu": f"{np.degrees(equations.nu(3, radians(66))):.1f}°",
        "M": f"{equations.M(3, radians(66)):.3g}",
    }
    assert list(caption_texts.facts(Chess(sheet="none"))) == ["z1", "z2", "r"]
    light = caption_texts.facts(Chess(polariser=0, analyser=90, pupil=0.3, focus=8))
    assert [*light.items()][-4:] == [
        ("pupil", "0.3 tiles"), ("focus", "8 tiles"), ("polariser", "0°"), ("analyser", "90°")
    ]  # fmt: skip


@pytest.mark.parametrize(
    "scene, texts",
    [
        (
            Spheres(alpha=90, sheet="ideal", z1=[3, 12, 6]),
            ["3 to 12 tiles", "0.5 to 2", "26.6 to 63.4°", "0.447 to 0.894"],
        ),
        # beyond the pole, on it and before it
        (
            Spheres(alpha=180, sheet="ideal", z1=[9, 6, 3]),
            ["3 to 9 tiles", "0.667 to 2", "0.0 to 180.0°, ?", "2 to infinite"],
        ),
        (Chess(alpha=180, sheet="ideal", z1=6), ["6 tiles", "1", "?", "infinite"]),
        # light meets the eye's plane in a line or not at all, in a mirrored image
        (Spheres(alpha=180, z1=[9, 6]), ["6 to 9 tiles", "0.667 to 1", "180.0°, ?", "2 to 61.1"]),
    ],
)
def test_ranges_are_from_the_least_to_the_greatest(scene, texts):
    assert [caption_texts.facts(scene)[name] for name in ("z1", "r", "nu", "M")] == texts


@pytest.mark.parametrize("sheet", ["ideal", "detailed"])
def test_at_the_pole_there_is_nothing_to_mark(sheet):
    assert drawn(Chess(alpha=180, z1=6, z2=6, sheet=sheet), caption="full", overlay=True).shape == (480, 640, 3)
    drawn(Chess(alpha=179.99999, z1=6, z2=6, sheet=sheet), overlay=True)


@pytest.mark.parametrize("size", list(BLANK))
def test_the_caption_is_legible_and_whole(size):
    for scene in (Chess(alpha=137.2, z1=1.234), Spheres(alpha=137.2)):
        above, picture, strip = parts(scene, size, caption="full")
        assert not len(above) and (picture == 120).all()  # the caption covers nothing
        assert strip.max() > 100 and np.median(strip) < 40 and len(strip) % 2 == 0  # light on dark
        if size[0] > 64:
            assert strip.max() == 255
            assert (strip[:, [0, -1]] < 40).all()  # no letter touches the edge
            assert len(strip) <= size[1] / 4
            rows = np.flatnonzero((strip > 150).any((1, 2)))
            assert abs(rows[0] + rows[-1] - len(strip)) < 0.2 * len(strip)  # in the middle


EXTREME = Chess(alpha=-359.99, z1=5000, z2=0.5, predicted_image=True)
EXTREMES = [
    EXTREME,
    Spheres(alpha=-179.9, z1=[0.3, 6, 5000], z2=6.00001),
    Spheres(sheet="single"),
]


def test_each_note_of_a_movie_is_broken_by_its_own_words():
    notes = "As z2 is far more than z1, the knight is nearly upright", "Neighbouring prisms displace light"
    widest = max(notes, key=text_width)
    lines = [
        [item.text for item in caption_strips._broken(caption_strips.Item(note, widest, None), 13, 16)]
        for note in notes
    ]
    assert len(lines[0]) == len(lines[1]) > 1
    for note, broken in zip(notes, lines, strict=True):
        assert " ".join(filter(None, broken)) == note
        assert max(map(text_width, broken)) <= 13.1


def test_only_single_letters_are_symbols():
    runs = _runs("König für l’eau z₁ f₁/f₂, M, P’s α, x²")
    assert [part for part, font in runs if font == "symbol"] == ["z", "f", "f", "M", "P", "α", "x"]


@pytest.mark.parametrize("size", [(320, 240), (240, 320)])
@pytest.mark.parametrize("scene", EXTREMES, ids=str)
def test_no_text_runs_out_of_the_picture(scene, size, monkeypatch):
    """Nor into the text beside it, even if a number is longer than the space that is reserved for it."""
    monkeypatch.setitem(BLANK, size, np.full((size[1], size[0], 3), 120, np.uint8))
    ends, write = [], caption_strips.write

    monkeypatch.setattr(overlay, "_letter", lambda *_: None)

    def written(draw, x, middle, text, height):
        ends.append(((draw, middle), x, x + text_width(text) * height))
        write(draw, x, middle, text, height)

    monkeypatch.setattr(caption_strips, "write", written)
    for option in ({"caption": "full"}, {"overlay": True}):
        ends.clear()
        overlay.annotated(BLANK[size], scene, Rendering(size=size, **option))
        assert min(start for _, start, _ in ends) >= 2 and max(end for _, _, end in ends) <= size[0] - 2
        for (line, _, end), (next_line, start, _) in pairwise(ends):
            assert line != next_line or start > end + 4


@pytest.mark.parametrize(
    ("scene", "name", "way"),
    [
        (Chess(sheet="mirror", alpha=80), "mirror line", np.exp(1j * radians(40))),
        (Chess(sheet="axis", axis=(0, 1, 0), alpha=20), "axis", 1j),
        (Chess(sheet="axis", axis=(0, 0.2, 1), alpha=20), None, 0),
    ],
)
def test_the_line_of_a_mirror_and_an_axis_is_drawn(scene, name, way, monkeypatch):
    monkeypatch.setattr(overlay, "loci", lambda *_: [])
    picture = drawn(scene, overlay=True)
    place = scene.camera.pixels((640, 480))[(picture == overlay.LINE_COLOUR[:3]).all(-1)]
    legend = overlay.legend(scene, Rendering(overlay=True))
    assert [text for text, colour in legend if colour == overlay.LINE_COLOUR] == [*filter(None, [name])]
    if name:
        turned = place / way
        assert np.ptp(turned.real) > 0.98 * scene.aperture and abs(turned.imag).max() < 2.7 * scene.view / 480
    else:
        assert not len(place)
    noted = drawn(scene, note="a note")
    assert (noted == overlay.LINE_COLOUR[:3]).all(-1).any() == bool(name)


def test_a_key_explains_outlines_with_a_caption_too():
    scene = Chess(predicted_image=True, direct_image=True)
    explained = [colour for _, colour in overlay.legend(scene, Rendering(caption="full"))]
    assert explained == [overlay.IMAGE_COLOUR, overlay.DIRECT_COLOUR]
    assert overlay.legend(scene, Rendering()) == [] == overlay.legend(Chess(), Rendering(caption="full"))


@pytest.mark.parametrize(
    ("scenes", "options"),
    [
        ([Chess(sheet="ideal", eye=(x, 0)) for x in (0, 3)], {"overlay": True}),
        ([Chess(sheet="ideal", eye=(Chess().aperture / 2, 0))], {"overlay": True, "stereo": "pair"}),
        ([Chess(sheet="none"), Chess(sheet="ideal"), Chess(sheet="none")], {"caption": "full"}),
    ],
    ids=["eye", "two eyes", "sheets"],
)
def test_all_frames_of_a_movie_are_equally_high(scenes, options, monkeypatch):
    """Also if a point leaves the window, so that one text less would explain what is drawn."""
    size = 300, 480
    png = encode.png(np.full((size[1], size[0], 3), 120, np.uint8))
    rendering = Rendering(size=size, **options)
    monkeypatch.setattr(still, "render_all", lambda scenes, *_: ([png] * len(views(s, rendering)) for s in scenes))
    assert len({made.shape for made in still.pictures(scenes, rendering, movie=True)}) == 1


@pytest.mark.parametrize("kind", ["short", "full"])
@pytest.mark.parametrize(
    "scenes",
    [
        [Chess(alpha=alpha) for alpha in (7, 178.5)],
        [Chess(alpha=180, z1=z1, sheet="ideal") for z1 in (0.6, 6)],
        [Spheres(alpha=alpha, sheet="ideal", z1=[1, 6, 50]) for alpha in (0, 100, 180)],
    ],
)
def test_a_movies_caption_stands_still(scenes, kind, monkeypatch):
    """Every value begins at the same place in all frames. The gaps between the widest values are equal."""
    found, write = [], caption_strips.write
    monkeypatch.setattr(caption_strips, "write", lambda draw, x, *a: (found[-1].append(x), write(draw, x, *a)))
    texts = caption_texts.captions(scenes, Rendering(caption=kind))
    for scene, caption in zip(scenes, texts, strict=True):
        found.append([])
        parts(scene, texts=caption)
    assert found[0] and all(places == found[0] for places in found)
    size = TEXT * 480 * texts[0].size
    gaps = [
        b - a - size * text_width(text, size) for (a, b), text in zip(pairwise(found[0]), texts[0].widest, strict=False)
    ]
    assert np.allclose([gap for gap in gaps if gap > 0], caption_strips.GAP * size)  # others are from line to line


@pytest.mark.parametrize(
    ("scenes", "texts"),
    [
        (
            [Chess(alpha=alpha, sheet="ideal") for alpha in (0, 1, 65.6, 180)],
            [
                f"rays turned by α = {alpha}°, knight appears {turned}, magnified {M} times"
                for alpha, turned, M in (
                    (0, "upright", "1.0"),
                    (1, "turned by <1°", "1.0"),
                    (66, "turned by 15°", "1.1"),
                    (180, "upright", "2.0"),
                )
            ],
        ),
        (
            [Chess(alpha=180, z1=z1, sheet="ideal") for z1 in (3, 6, 9)],
            [
                f"z₁ = {z1} tiles behind the window, "
                f"rays turned by α = 180°, knight appears {turned}, magnified {M} times"
                for z1, turned, M in ((3, "upright", "3.0"), (6, "turned by ?", "?"), (9, "turned by 180°", "5.0"))
            ],
        ),
        ([Spheres(alpha=alpha) for alpha in (0, 140)], ["rays turned by α = 0°", "rays turned by α = 140°"]),
        (
            [Chess(sheet="ideal", alpha=30, window=f"alpha={alpha},z=2") for alpha in (10, 50)],
            ["α₂ = 10°, knight appears turned by 14°", "α₂ = 50°, knight appears turned by 20°"],
        ),
        (
            [Chess(eye=(x, 0)) for x in (-0.5, -0.04, 1)],
            ["eye 0.5 tiles to the left", "eye in the middle", "eye 1.0 tiles to the right"],
        ),
        (
            [Chess(sheet="refraction", ratio=0.7, alpha=x) for x in (0, 90)],
            [f"index behind/in front = 0.7, light turned by {x}°" for x in (0, 90)],
        ),
        ([Chess(sheet="mirror", alpha=x) for x in (0, 91)], ["mirror line at 0°", "mirror line at 46°"]),
        (
            [Chess(window=f"z={x},alpha=120", alpha=120, sheet="ideal", z1=2) for x in (0.5, 2)],
            [
                "windows 0.5 tiles apart, knight appears turned by -15°, magnified 1.7 times",
                "windows 2.0 tiles apart, knight appears upright, magnified 2.5 times",
            ],
        ),
        ([Chess(sheet="law", law="x - k*X*z, y, z", parameter="k=0.3")], ["k = 0.3"]),
        (
            [Chess(alpha=0, window="alpha=0,z=1", z1=z1) for z1 in (2, 3)],
            [f"z₁ = {z1} tiles behind the last window" for z1 in (2, 3)],
        ),
        ([Chess(sheet="ideal", index=index) for index in (1.3, 2)], ["", ""]),  # changes nothing
        (
            [Spheres(sheet="ideal", window="z=2", alpha=alpha) for alpha in (0, 90)],
            ["rays turned by α = 0° in each window", "rays turned by α = 90° in each window"],
        ),
        (
            [Chess(sheet="law", law="x*k, y, z", parameter={"k": 1}, window=f"z=1,parameter=k={k}") for k in (3, 5)],
            ["k₂ = 3", "k₂ = 5"],
        ),
        # words and factors are those of each kind of sheet
        (
            [Chess(sheet="mirror", alpha=60, window="z=2,sheet=ideal,alpha=30", z1=3)],
            ["mirror line at 30°, rays turned by α = 30°"],
        ),
        (
            [Chess(sheet="law", law="x, alpha*y, z", parameter="alpha=0.3", window="z=2,sheet=ideal,alpha=30")],
            ["α = 0.3, rays turned by α = 30°"],
        ),
        ([Chess(sheet="law", law="x, z1*y, z", parameter="z1=0.3")], ["z₁ = 0.3"]),
        ([Chess(pupil=0.1, focus=focus) for focus in (5, "best")], ["focus = 5 tiles", "focus = best"]),
        ([Chess(polariser=angle) for angle in (10, "none")], ["polariser = 10°", "polariser = none"]),
        ([Chess(alpha=60), Chess(sheet="mirror", alpha=60)], ["rays turned by α = 60°", "mirror line at 30°"]),
        # a value that only some frames have is not rounded
        (
            [Chess(alpha=0), Chess(alpha=0, window="z=1.5,alpha=20.5")],
            [
                "window 2 at none, knight appears upright",
                "α₂ = 20.5°, windows 1.5 tiles apart, knight appears turned by 4°",
            ],
        ),
    ],
)
def test_a_short_caption_says_what_moves(scenes, texts):
    found = caption_texts.captions(scenes, Rendering(caption="short"))
    assert [", ".join(filter(None, caption.texts)) for caption in found] == texts


def test_a_number_rounded_to_that_of_a_frame_with_an_image_has_a_sign():
    """At a gap of 2 tiles the rays meet, and at 1.97 they do not, as the side view says."""
    scenes = [Chess(sheet="ideal", alpha=120, z2=8, z1=2, window=f"z={z},alpha=120") for z in (1, 1.97, 2, 4)]
    for side_view, text in ((True, "windows ~2.0 tiles apart"), (False, "windows 2.0 tiles apart")):
        found = caption_texts.captions(scenes, Rendering(caption="short", side_view=side_view))
        assert [caption.texts[0] for caption in found[1:3]] == [text, "windows 2.0 tiles apart"]
    # what is exact has no sign: other numbers decide where the rays meet
    scenes = [
        Chess(sheet="ideal", alpha=alpha, z2=8, z1=2, window=f"z={z},alpha=120")
        for alpha, z in ((120, 2), (120, 3), (100, 2), (110, 4))
    ]
    found = caption_texts.captions(scenes, Rendering(caption="short", side_view=True))
    assert not [text for caption in found for text in caption.texts if "~" in text]


def rows_of(monkeypatch, items, width, height=240):
    """Return the texts of each line of a strip, and the height of its letters."""
    written = []
    monkeypatch.setattr(
        caption_strips, "write", lambda draw, x, middle, text, size: written.append((middle, text, size))
    )
    caption_strips.strip(items, width, height)
    return [[text for y, text, _ in written if y == line] for line in sorted({y for y, *_ in written})], written[0][2]


def test_a_long_text_is_broken_after_the_same_words_in_all_frames(monkeypatch):
    note = "Question three: which way does the knight turn, and by how much does it turn?"
    items = [caption_strips.Item("α = 66°", "α = 166°"), caption_strips.Item(note, note)]
    found, size = rows_of(monkeypatch, items, 320)
    assert size == 12 and found[0] == ["α = 66°"] and " ".join(text for (text,) in found[1:]) == note
    said = "rays turned by α = 120° in each window"
    for width in range(110, 260, 10):
        found, _ = rows_of(monkeypatch, [caption_strips.Item(said, said)], width)
        assert "α = 120°" in " / ".join(text for line in found for text in line), width
    found, _ = rows_of(monkeypatch, [caption_strips.Item(note, note)] * 6, 160)  # the text is made smaller
    assert len(found) <= caption_strips.LINES and {text for line in found for text in line} == {note}


def test_a_note_ends_the_caption():
    scenes = [Chess(z1=z1, sheet="none") for z1 in (2, 3)]
    for caption, texts in (("none", []), ("short", ["z₁ = 2 tiles behind the window"])):
        noted = Rendering(caption=caption, note="a note")
        assert noted.annotated and caption_texts.captions(scenes, noted)[0].texts == [*texts, "a note"]
    with pytest.raises(InputError, match="note = 'Ж': is not allowed.*Latin"):
        Rendering(note="Ж")  # povgen's font lacks it


def test_the_letters_of_a_note_are_in_the_font():
    """A letter that the font lacks would be drawn as the empty box that stands for U+FFFF."""
    font = _font(40)
    lacking = bytes(font.getmask("\uffff"))
    allowed = [letter for letter in map(chr, range(0x20, 0x2100)) if not refused_letter(letter)]
    assert len(allowed) > 250 and not [x for x in allowed if x.strip() and bytes(font.getmask(x)) == lacking]


def refused_letter(letter):
    try:
        Rendering(note=letter)
    except InputError:
        return True
    return False


@pytest.mark.parametrize(
    ("scene", "letters"),
    [
        (Chess(sheet="ideal"), "LEP"),
        (Spheres(alpha=120, sheet="ideal"), "LE"),  # one L, and a P for each sphere
        (Chess(sheet="ideal", eye=(0, 4)), "LP"),  # E is not in the window
    ],
)
def test_points_in_the_window_have_their_letters(scene, letters, monkeypatch):
    found = {}
    monkeypatch.setattr(overlay, "_letter", lambda picture, name, place, *_: found.update({name: place}))
    picture = drawn(scene, overlay=True)
    assert [*found] == [*letters]
    for name, at in found.items():
        x, y = round(at.real), round(at.imag)
        z = scene.camera.pixels((640, 480))[y, x]
        right = {"L": scene.L, "E": scene.E, "P": scene.apparent_position(scene.L, scene.distances[0])}[name]
        assert abs(z - right) < scene.view / 480 and (picture[y, x] != 120).any()


KNIGHT_BESIDE = Chess(sheet="ideal", x=[0, 3.3], z1=[3, 3])
WIDE = [
    (Chess(sheet="ideal"), {"caption": "full", "side_view": True, "note": "a note", "overlay": True}),
    (KNIGHT_BESIDE, {"caption": "short"}),
    (Room([Piece(z=2, name="mine")]), {"caption": "full", "side_view": True}),
    (
        Chess(alpha=-359.99, z1=5000, z2=0.5, predicted_image=True),
        {"caption": "full", "side_view": True, "overlay": True},
    ),
]


@pytest.mark.parametrize(("scene", "options"), WIDE)
def test_texts_stand_beside_a_wide_picture(scene, options, monkeypatch):
    """All together has the asked size. Only surroundings are cut off. The smallest letters are 1/40 of the height."""
    sizes, write = [], caption_strips.write

    def written(draw, x, middle, text, size, *look, **more):
        sizes.append(size)
        assert x >= 0 and x + size * text_width(text, size) <= draw.im.size[0] + 1
        write(draw, x, middle, text, size, *look, **more)

    monkeypatch.setattr(caption_strips, "write", written)
    monkeypatch.setattr(side, "write", written)
    size = 1280, 720
    png = encode.png(np.broadcast_to(np.linspace(0, 250, 1280).astype(np.uint8)[:, None], (720, 1280, 3)))
    made = still.picture([png] * len(views(scene, Rendering())), scene, Rendering(size=size, **options))
    assert made.shape == (720, 1280, 3) and min(sizes) >= 720 / 40
    assert still.picture([png], scene, Rendering(size=size, overlay=False)).shape == made.shape
    cut = scene in (WIDE[0][0], WIDE[3][0])
    across = made[5 if cut else 360, [0, 767], 0]  # what is cut off was darker and brighter
    assert across.tolist() == pytest.approx([50, 199] if cut else [0, 250], abs=1)
    assert (made[0, 768:] == STRIP).all()
