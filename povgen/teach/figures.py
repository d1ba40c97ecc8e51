"""The paper's six figures, each with a caption that says what it shows and how well it agrees with the equations.

Coordinates are those of the scenes: x right, y up, z away from the eye. Drawings in space are seen from aside: z to the
left, so that light runs to the right.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import cos, degrees, pi, radians, sin
from pathlib import Path

import numpy as np

from povgen.files import save
from povgen.measure import probes, verify
from povgen.measure.plotting import Axes, Figure, save_drawing, style
from povgen.measure.probes import Directions, PiecePositions, Positions
from povgen.optics import prism, rotation, trace
from povgen.rendering.frames import read, render_all
from povgen.scene.models import Chess, Scene, Spheres
from povgen.settings import Rendering
from povgen.video import overlay

WIDTH = 7.0  # inches: two columns of a journal
PRINT = {"font.size": 10, "axes.titleweight": "normal", "axes.titlesize": 10, "figure.dpi": 200, "savefig.dpi": 200}
RAY, SHEET, GREY = "#c1272d", "#0b5fa5", "#777777"
CONSTANT_ALPHA, CONSTANT_R = "#0b5fa5", "#d1603d"


@dataclass(frozen=True)
class Drawn:
    """A figure and its caption; whether it is a drawing, which is kept as SVG as well, or a montage of frames."""

    figure: Figure
    caption: str
    drawing: bool = False


def save_figure(number: int, folder: Path, rendering: Rendering) -> list[Path]:
    """Make figure 1 to 6 of the paper: figureN.png, of a drawing figureN.svg as well, and its caption, figureN.md."""
    title, make = FIGURES[number]
    with style(**PRINT):
        drawn = make(rendering)
        files = [folder / f"figure{number}{kind}" for kind in ([".png", ".svg"] if drawn.drawing else [".png"])]
        save_drawing(drawn.figure, *files)
    caption = folder / f"figure{number}.md"
    text = " ".join(drawn.caption.split())
    save(f"![{title}](figure{number}.png)\n\n**Figure {number}.** {text}\n\n".encode(), caption)
    return [*files, caption]


def dove_prism_sheet(rendering: Rendering) -> Drawn:
    """Figure 1: a sheet in space, and a ray through it: its real path, and as it would be mirrored."""
    count, far, half = 5, 5.2, 1.7
    height, length = 1 - prism.AIR_GAP, (1 - prism.AIR_GAP) * prism.aspect()
    start, slope = np.array([-1.0, -0.97, far]), np.array([0.2, 0.25, -1.0])
    sheet = (trace.Sheet(0.0, 0.0),)
    rays = [trace.trace(start[None], slope[None], sheet, count, count, most=most) for most in (1, 2, 3, 60)]
    out = rays[-1].direction[0] / -rays[-1].direction[0][2]
    path = [start, *(ray.position[0] for ray in rays)]
    path.append(path[-1] + (far + path[-1][2]) * out)
    mirrored = rotation.mirror(slope, 0.0)
    crossing = start + far * slope  # of the sheet's middle plane, without prisms
    off = _angle(out, mirrored)
    shift = np.linalg.norm(path[-1] - crossing - far * mirrored)

    figure = Figure(figsize=(WIDTH, 3.7))
    ax = _space(figure.add_axes((0, 0, 1, 1)))
    for n in range(count):
        y = n - count / 2
        profile = [
            (y, -length / 2),
            (y, length / 2),
            (y + height, length / 2 - height),
            (y + height, height - length / 2),
        ]
        near, back = ([(x, *corner) for corner in profile] for x in (-half, half))
        _faces(ax, [back, *([near[k - 1], near[k], back[k], back[k - 1]] for k in range(4)), near], "#cfe2f3", 0.35)
    plane = [(x, crossing[1], z) for x, z in ((-half, -2.6), (half, -2.6), (half, 2.6), (-half, 2.6))]
    _faces(ax, [plane], "#999999", 0.35, edge=GREY)
    _line(ax, [crossing, crossing + far * slope], GREY, 1.2, ":", arrow=True)
    _line(ax, [start, crossing, crossing + far * mirrored], "black", 1.3, "--", arrow=True)
    _line(ax, path, RAY, 2.2, arrow=True)
    _axes(ax, (0.6, -3.3, 5.2))
    for end, text, up in (
        (path[-1], "real path", -0.22),
        (crossing + far * mirrored, "mirrored", 0.36),
        (crossing + far * slope, "without the sheet", 0.2),
    ):
        _write(ax, _seen(end) + (0.1, up), text, ha="right", fontsize=9)
    return Drawn(
        figure,
        f"""Ray-optics of a Dove-prism sheet, drawn with prisms as large as these. Red: a ray's real path,
        refracted at the
        facets and totally reflected at the base of a prism, by povgen's exact ray trace. Dashed: the ray mirrored at
        the grey plane, which is normal to the sheet, parallel to the prisms, and goes through the point in which
        the ray
        meets the middle of the sheet. Dotted: the ray without the sheet. The sheet inverts the y component of the
        direction: measured, the ray leaves in the mirrored direction to within {_power(off)} degrees, shifted by
        {shift:.2f}
        of a prism's height. As prisms are made smaller the shift vanishes; the direction remains.""",
        drawing=True,
    )


def mirroring(rendering: Rendering) -> Drawn:
    """Figure 2: a picture, mirrored about the vertical, then about an axis at alpha/2 = 16 deg, is turned by 32 deg."""
    alpha = radians(32)
    scene = Chess(sheet="none", z1=2.2, offset=(0, -0.75))
    picture = read(next(render_all([scene], rendering)))
    side = rendering.size[1] // 2
    place = (np.arange(side) + 0.5) / side * 2 - 1
    z = place - 1j * place[:, None]
    vertical, oblique = 1j, 1j * np.exp(-0.5j * alpha)  # directions of the axes; clockwise, as the paper draws it
    once = vertical**2 * z.conj()
    twice = vertical**2 * (oblique**2 * z.conj()).conj()
    original, mirrored, turned, expected = (
        _looked_up(picture, scene, -0.5j + 0.7 * from_) for from_ in (z, once, twice, z * np.exp(1j * alpha))
    )
    off = np.sqrt(np.mean((turned - expected)[abs(z) < 1] ** 2)) / 255

    figure = Figure(figsize=(WIDTH, 2.75), layout="constrained")
    axes = figure.subplots(1, 3)
    titles = ("a picture", "mirrored about the vertical", r"then about an axis at $\alpha/2 = 16\degree$")
    for ax, panel, title in zip(axes, (original, mirrored, turned), titles, strict=True):
        shown = ax.imshow(panel / 255, extent=(-1, 1, -1, 1))
        disc = 0.985 * np.exp(1j * np.linspace(0, 2 * pi, 241))
        shown.set_clip_path(ax.fill(*_xy(disc), fill=False, linewidth=0.8)[0])
        ax.set(xlim=(-1.25, 1.25), ylim=(-1.25, 1.35))
        ax.set_title(title, loc="center")
        ax.axis("off")
    for ax, axis in ((axes[1], vertical), (axes[2], oblique)):
        ax.plot(*_xy(np.array([-1.2, 1.2]) * axis), "--", color="black", linewidth=1.3)
    axes[2].plot(*_xy(np.array([-1.2, 1.2]) * vertical), ":", color="black", linewidth=1)
    _arc(axes[2], 0, 1.08, pi / 2, pi / 2 - alpha / 2, r"$\alpha/2$", 0.12)
    return Drawn(
        figure,
        f"""Mirroring and rotation. From left to right: a picture, the picture mirrored about the vertical, and
        that mirrored
        again, about an axis at alpha/2 = 16 degrees to the vertical. It is now turned by alpha = 32 degrees:
        measured, the
        RMS difference between it and the first picture turned once is {_power(off)} (white is 1).""",
        drawing=True,
    )


def vary_alpha(rendering: Rendering) -> Drawn:
    """Figure 3: frames of the alpha movie, with the predicted image in the one at 66 degrees."""
    scenes = [Chess(alpha=alpha, predicted_image=alpha == 66) for alpha in (0, 33, 66, 99, 132, 180)]
    figure, _ = _montage(scenes, rendering, [rf"$\alpha = {scene.alpha:g}\degree$" for scene in scenes])
    return Drawn(
        figure,
        f"""A chess piece z1 = 2 tiles behind 2 x 100 Dove prisms that rotate light rays by alpha, seen from z2 = 6
        tiles
        before them. At alpha = 0 the sheets cancel each other; at alpha = 180 degrees they image the piece to the
        same
        distance before them; between, it appears turned and scaled. The translucent piece in the frame of 66 degrees
        stands in the plane of the sheets, turned and scaled as predicted: it lies on the piece that is seen
        through them.
        {_pieces_agree(scenes)}""",
    )


def vary_z1(rendering: Rendering) -> Drawn:
    """Figure 4: frames of the z1 movie."""
    scenes = [Chess(alpha=90, z1=z1) for z1 in (0.6, 1.5, 3, 6, 15, 60)]
    figure, _ = _montage(scenes, rendering, [f"$z_1 = {scene.z1:g}$" for scene in scenes])
    turned = degrees(verify.horizon_angle(Directions(sheet="detailed", alpha=90), verify.SMALL))
    return Drawn(
        figure,
        f"""A chess piece seen through 2 x 100 Dove prisms that rotate light rays by alpha = 90 degrees, from z2 =
        6 tiles
        before them. The farther the piece is behind the sheets (z1, in tiles), the more it appears turned. The
        horizon,
        infinitely far away, is turned by alpha in every frame: measured, by {turned:.2f} degrees.
        {_pieces_agree(scenes)}""",
    )


def geometry(rendering: Rendering) -> Drawn:
    """Figure 5: a ray from L by P to E in space, its projection, and the circles that P lies on."""
    alpha, z1, z2 = radians(60), 1.6, 2.4
    figure = Figure(figsize=(WIDTH, 6.3))
    _geometry_in_space(_space(figure.add_axes((0.03, 0.46, 0.94, 0.54))), alpha, z1, z2)
    _projection(figure.add_axes((0.02, 0.02, 0.46, 0.46)), z2 / z1, alpha)
    _circles(figure.add_axes((0.52, 0.01, 0.46, 0.46)))
    for label, x, y in (("(a)", 0.02, 0.96), ("(b)", 0.02, 0.46), ("(c)", 0.51, 0.46)):
        figure.text(x, y, label, fontsize=12, fontweight="bold")
    prisms, turned, missed = _traced_through_P(alpha, z1, z2)
    return Drawn(
        figure,
        f"""A light ray (red) from a point light source L to a ray-rotating sheet (blue), which it meets at P, and
        on to the
        eye E. (a) In space: the ray is at the same angle theta to the normal before the sheet and behind it. Grey:
        its
        projection into the sheet's plane. (b) The projection, in coordinates xi, psi with L = 0 and E = 1. E - P is
        r exp(i alpha) times P, so that P = 1/(1 + r exp(i alpha)); L appears turned about E by nu = arg(1 - P) (eq. 8
        corrected). (c) P for constant r (solid) and for constant alpha (dashed): circles, which meet at right angles.
        Measured with the exact ray trace of 2 x {prisms} prisms at the angle alpha and the ratio r of (a) and (b):
        light that
        reaches E from P has been turned by {turned:.4f} degrees (alpha is {degrees(alpha):.0f}) and comes from within
        {missed:.4f} of L, on average (E - L is 1).""",
        drawing=True,
    )


def spheres(rendering: Rendering) -> Drawn:
    """Figure 6: frames of the spheres movie, with predicted positions and the circle that they lie on."""
    scenes = [Spheres(alpha=alpha) for alpha in (0, 30, 60, 90, 120, 150)]
    figure, axes = _montage(scenes, rendering, [rf"$\alpha = {scene.alpha:g}\degree$" for scene in scenes], 1.2)
    for ax, scene in zip(axes, scenes, strict=True):
        for line in overlay.loci(scene)[0][0]:
            ax.plot(*_xy(line), color="white", linewidth=1.8)
            ax.plot(*_xy(line), color="black", linewidth=0.9)
        seen = np.array(overlay.positions(scene))
        ax.plot(*_xy(seen), "o", markersize=4, markerfacecolor="#f0e442", markeredgecolor="black", markeredgewidth=0.7)
    targets = [
        Positions(sheet="detailed", alpha=scene.alpha, z1=z1, L=scene.L, extent=0.15 * (1 + z1 / scene.z2))
        for scene in scenes[1:]
        for z1 in scene.distances
    ]
    found = [
        (target, seen.position) for target, seen in verify.located(targets, (320, 240)) if np.isfinite(seen.position)
    ]
    thick = [place - target.apparent_position(target.L, target.z1) for target, place in found]
    thin = [
        place - rotation.apparent_position(target.L, target.E, target.z1, target.z2, radians(target.alpha))
        for target, place in found
    ]
    return Drawn(
        figure,
        f"""Green spheres on one normal of 2 x 100 Dove-prism sheets, at z1 = 2^n z2, n = -5 to 5, seen from z2 = 6
        tiles; the
        farther the darker. Dots: their predicted positions. Line: the circle of constant alpha, through L and E,
        that they
        lie on. Measured with a coded target in the place of each sphere, of which {len(found)} of {len(targets)}
        could be
        located (alpha = 0 left out, where sheets of parallel prisms make bands): off the prediction for prisms of
        this size by
        {verify.px(verify.rms(np.abs(thick))):.2f} pixels, off eq. 7, which is for infinitely small ones, by
        {verify.px(verify.rms(np.abs(thin))):.2f} (RMS, in a picture of 1280x960).""",
    )


FIGURES: dict[int, tuple[str, Callable[[Rendering], Drawn]]] = {
    1: ("A ray on its way through a Dove-prism sheet", dove_prism_sheet),
    2: ("A picture mirrored twice is turned", mirroring),
    3: ("A chess piece seen through ray-rotating sheets at six angles alpha", vary_alpha),
    4: ("A chess piece seen through 90-degree sheets at six distances", vary_z1),
    5: ("A ray from L by P to E, and the circles that P lies on", geometry),
    6: ("Spheres on a normal of the sheets, seen on circles", spheres),
}


def _montage(
    scenes: Sequence[Scene], rendering: Rendering, labels: list[str], reach: float = 1.45
) -> tuple[Figure, Iterable]:
    """The scenes' frames as far as `reach` from the middle, two rows of three, in the plane z = 0, tiles."""
    figure = Figure(figsize=(WIDTH, 5.05))
    layout = {"left": 0.005, "right": 0.995, "top": 0.945, "bottom": 0.005, "hspace": 0.13, "wspace": 0.03}
    axes = figure.subplots(2, 3, gridspec_kw=layout).ravel()
    for ax, scene, frame, label in zip(axes, scenes, render_all(scenes, rendering), labels, strict=True):
        picture = read(frame)
        high = scene.view_height / 2
        wide = high * picture.shape[1] / picture.shape[0]
        ax.imshow(picture, extent=(-wide, wide, -high, high))
        ax.set(xlim=(-reach, reach), ylim=(-reach, reach))
        ax.set_title(label, loc="center", pad=4)
        ax.axis("off")
    return figure, axes


def _pieces_agree(scenes: list[Chess]) -> str:
    """How the pieces appear turned and scaled about the eye, measured, and by eqs. 8 and 9."""
    pieces = [PiecePositions(**scene.model_dump(include={"alpha", "z1", "z2", "offset", "piece"})) for scene in scenes]
    told = []
    for scene, frame in zip(pieces, probes.decoded(pieces, verify.SMALL), strict=True):
        a = verify.about_eye(scene, frame, verify.SMALL)
        r, alpha = scene.z2 / scene.z1, radians(scene.alpha)
        nu, M = degrees(rotation.nu(r, alpha)), rotation.M(r, alpha)
        told.append(f"{degrees(np.angle(a)) + 0:.1f} ({nu + 0:.1f}), {abs(a):.3f} ({M:.3f})")
    return f"""Measured on a coded piece, frame by frame: nu in degrees and M, in brackets those of eqs. 8 and 9
        (corrected) for infinitely small prisms: {"; ".join(told)}."""


def _traced_through_P(alpha: float, z1: float, z2: float) -> tuple[int, float, float]:
    """The number of prisms; the mean angle, degrees, by which they turn light from P to E; how far from L it starts."""
    prisms, window = 3000, 4.0
    place = complex(rotation.P(z2 / z1, alpha))
    # rays to some prisms round P: each is shifted by a part of a prism, either way
    spread = np.random.default_rng(5).uniform(-1, 1, (4000, 2)) * window / prisms
    direction = np.column_stack((place.real + spread[:, 0] - 1, place.imag + spread[:, 1], np.full(len(spread), z2)))
    rays = trace.trace(np.array([[1.0, 0, -z2]]), direction, trace.pair(alpha, window, prisms), window, prisms)
    x, y, z = rays.position[rays.designed].T
    dx, dy, dz = rays.direction[rays.designed].T
    before, after = direction[rays.designed] @ (1, 1j, 0), dx + 1j * dy
    start = x + 1j * y + after / dz * (z1 - z)
    return prisms, degrees(np.angle(before / after).mean()), abs(start.mean())


def _geometry_in_space(ax: Axes, alpha: float, z1: float, z2: float) -> None:
    """The ray from L by P to E, the sheet, and the projections into its plane."""
    L, E = -0.6 + 0.25j, 0.6 + 0.25j
    place = complex(rotation.apparent_position(L, E, z1, z2, alpha))

    def at(point: complex, z: float) -> tuple[float, float, float]:
        return point.real, point.imag, z

    _faces(ax, [[(x, y, 0) for x, y in ((-1.05, -0.75), (1.05, -0.75), (1.05, 0.75), (-1.05, 0.75))]], "#9fc5e8", 0.5)
    _line(ax, [at(place, z1), at(place, -z2)], GREY, 0.9, "-.")
    for foot, z in ((L, z1), (E, -z2)):
        _line(ax, [at(foot, z), at(foot, 0), at(place, 0)], GREY, 1.3, ":")
    for foot in (L, E):
        _line(ax, [at(foot, 0), at(place, 0)], GREY, 1.6)
    _line(ax, [at(L, z1), at(place, 0)], RAY, 2.2)
    _line(ax, [at(place, 0), at(E, -z2)], RAY, 2.2, arrow=True)
    ax.plot(*np.transpose([_seen(at(L, z1)), _seen(at(place, 0)), _seen(at(E, -z2))]), "o", color="black", markersize=4)
    for point, text, dx, dy in (
        (at(L, z1), "$L$", -0.1, 0),
        (at(place, 0), "$P$", 0.02, -0.13),
        (at(E, -z2), "$E$", 0.12, 0),
        (at(L, z1 / 2), "$z_1$", 0, 0.1),
        (at(E, -z2 / 2), "$z_2$", 0, 0.1),
        (at((L + place) / 2, 0), "$p_1$", -0.02, 0.13),
        (at((E + place) / 2, 0), "$p_2$", 0.09, -0.06),
        (at(-0.1 + 0.6j, 0), "sheet", 0, 0),
    ):
        _write(ax, _seen(point) + (dx, dy), text, fontsize=11)
    for z, sense in ((z1, 1), (-z2, -1)):  # theta, between the normal and the ray, at P
        normal, ray = (_seen(at(point, z)) - _seen(at(place, 0)) for point in (place, L if sense > 0 else E))
        start, end = (np.arctan2(*vector[::-1]) for vector in (normal, ray))
        end = start + (end - start + pi) % (2 * pi) - pi
        _arc(ax, complex(*_seen(at(place, 0))), 0.95, start, end, r"$\theta$", -0.1)
    _axes(ax, (-1.4, -0.95, 1.75), 0.45)


def _projection(ax: Axes, r: float, alpha: float) -> None:
    """The triangle L, P, E in the plane of the sheet with L = 0, E = 1, and the angles in it."""
    place = complex(rotation.P(r, alpha))
    _plane(ax, (-0.25, 1.25), (-0.62, 0.42))
    ax.plot(*_xy(place * np.array([1, 1.6])), ":", color=GREY, linewidth=1.3)
    for start, end in ((0, place), (place, 1)):
        _arrow(ax, _xy(start), _xy(end), RAY, 2.2)
    _arc(ax, place, 0.2, np.angle(place), np.angle(1 - place), r"$\alpha$", 0.07)
    _arc(ax, 1, 0.3, pi, pi + rotation.nu(r, alpha), r"$\nu$", 0.07)
    for point, text, offset in (
        (0, "$L = 0$", -0.1 + 0.09j),
        (1, "$E = 1$", 0.03 + 0.09j),
        (place, "$P$", -0.05 - 0.08j),
    ):
        ax.plot(*_xy(point), "o", color="black", markersize=4)
        _write(ax, _xy(point + offset), text, fontsize=11)
    _write(ax, _xy(place / 2 - 0.06 - 0.06j), "$p_1$", color=RAY)
    _write(ax, _xy((1 + place) / 2 + 0.1 - 0.09j), "$p_2 = r\\,p_1$", color=RAY)


def _circles(ax: Axes) -> None:
    """Where P lies for constant r and for constant alpha, by eq. 7."""
    _plane(ax, (-1.15, 2.15), (-1.6, 1.6))
    turn = np.linspace(-pi, pi, 721)
    for r, text in ((1 / 4, "1/4"), (1 / 2, "1/2"), (1, "$r = 1$"), (2, "2"), (4, "4")):
        place = rotation.P(r, turn)
        ax.plot(*_xy(np.where(abs(place) > 6, np.nan, place)), color=CONSTANT_R, linewidth=1.2)
        _label(ax, rotation.P(r, radians(-133 if r == 1 else -155)), text, CONSTANT_R)
    ratio = np.geomspace(1e-3, 1e3, 721)
    for alpha in (-150, -120, -90, -60, -30, 0, 30, 60, 90, 120, 150):
        ax.plot(*_xy(rotation.P(ratio, radians(alpha))), "--", color=CONSTANT_ALPHA, linewidth=1.2)
        if abs(alpha) > 30:
            text = rf"$\alpha = {alpha}\degree$" if alpha == 150 else rf"${alpha}\degree$"
            _label(ax, rotation.P(1 / 1.4, radians(alpha)), text, CONSTANT_ALPHA)
    for point, text, offset in ((0, "$L$", -0.15 - 0.12j), (1, "$E$", 0.15 - 0.12j)):
        ax.plot(*_xy(point), "o", color="black", markersize=4, zorder=5)
        box = {"facecolor": "white", "edgecolor": "none", "pad": 0.6}
        _write(ax, _xy(point + offset), text, fontsize=11, zorder=5, bbox=box)


def _plane(ax: Axes, x: tuple[float, float], y: tuple[float, float]) -> None:
    """Axes xi and psi through the origin, in which a circle is a circle."""
    ax.set(xlim=x, ylim=y, aspect="equal")
    ax.axis("off")
    for start, end, name, offset in (
        ((x[0], 0), (x[1], 0), r"$\xi$", (-4, -9)),
        ((0, y[0]), (0, y[1]), r"$\psi$", (9, -4)),
    ):
        _arrow(ax, start, end, GREY, 0.9)
        ax.annotate(name, end, xytext=offset, textcoords="offset points", ha="center", va="center")


def _label(ax: Axes, place: complex, text: str, colour: str) -> None:
    box = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
    _write(ax, _xy(place), text, color=colour, fontsize=7.5, bbox=box)


def _arc(ax: Axes, centre: complex, radius: float, start: float, end: float, name: str, room: float) -> None:
    """An angle from start to end, radians, and its name that far outside."""
    ax.plot(*_xy(centre + radius * np.exp(1j * np.linspace(start, end, 60))), color="black", linewidth=1)
    _write(ax, _xy(centre + (radius + room) * np.exp(0.5j * (start + end))), name)


def _write(ax: Axes, place: Iterable[float], text: str, **look) -> None:
    x, y = place
    ax.text(x, y, text, **{"ha": "center", "va": "center"} | look)


def _xy(place) -> tuple:
    return np.real(place), np.imag(place)


def _looked_up(picture: np.ndarray, scene: Scene, place: np.ndarray) -> np.ndarray:
    """The picture's colours at places of the plane z = 0, interpolated between pixels."""
    tile = picture.shape[0] / scene.view_height
    x = picture.shape[1] / 2 + place.real * tile - 0.5
    y = picture.shape[0] / 2 - place.imag * tile - 0.5
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    fx, fy = (x - left)[..., None], (y - top)[..., None]
    above, below = (picture[top + n, left] * (1 - fx) + picture[top + n, left + 1] * fx for n in (0, 1))
    return above * (1 - fy) + below * fy


def _space(ax: Axes) -> Axes:
    ax.set_aspect("equal")
    ax.axis("off")
    return ax


ASIDE, ABOVE = radians(32), radians(16)  # from where space is seen


def _seen(point) -> np.ndarray:
    """Where a point (x, y, z) of space lies in a drawing: parallel projection, z to the left, x into the page."""
    x, y, z = np.asarray(point, float)
    right, depth = x * sin(ASIDE) - z * cos(ASIDE), x * cos(ASIDE) + z * sin(ASIDE)
    return np.array([right, y * cos(ABOVE) + depth * sin(ABOVE)])


def _faces(ax: Axes, faces: list, colour: str, opacity: float, edge: str = SHEET) -> None:
    """Translucent faces, each a list of corners, the farthest first."""
    for face in faces:
        corners = np.transpose([_seen(corner) for corner in face])
        ax.fill(*corners, facecolor=colour, alpha=opacity, linewidth=0)
        ax.fill(*corners, fill=False, edgecolor=edge, linewidth=0.7)


def _line(ax: Axes, points: Iterable, colour: str, width: float, dashes: str = "-", arrow: bool = False) -> None:
    """A line through points of space; with an arrow at its end."""
    seen = np.array([_seen(point) for point in points])
    ax.plot(*seen.T, dashes, color=colour, linewidth=width, solid_joinstyle="round")
    if arrow:
        step = (seen[-1] - seen[-2]) / np.linalg.norm(seen[-1] - seen[-2])
        _arrow(ax, seen[-1] - 1e-3 * step, seen[-1], colour, width)


def _arrow(ax: Axes, start, end, colour: str, width: float) -> None:
    shape = {"arrowstyle": "-|>,head_length=0.5,head_width=0.22", "color": colour, "linewidth": width}
    ax.annotate("", end, start, arrowprops=shape | {"shrinkA": 0, "shrinkB": 0, "mutation_scale": 14})


def _axes(ax: Axes, origin: tuple[float, float, float], size: float = 0.9) -> None:
    """Arrows along x, y and z."""
    for n, name in enumerate("xyz"):
        end = np.array(origin, float)
        end[n] += size
        _line(ax, [origin, end], "black", 1, arrow=True)
        end[n] += 0.28 * size
        _write(ax, _seen(end), f"${name}$", fontsize=11)


def _angle(a: np.ndarray, b: np.ndarray) -> float:
    """Between two directions, degrees."""
    return degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), np.dot(a, b)))


def _power(value: float) -> str:
    """A small number as its order of magnitude, rounded up; nothing measured is nearer to 0 than rounding."""
    return f"10^{int(np.ceil(np.log10(max(value, 1e-15))))}"
