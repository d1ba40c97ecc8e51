"""Draw the paper's six figures. captions/ has the text of the captions; `agreement` measures their numbers.

In drawings of space the z axis points to the left, so that light travels to the right.
"""

from collections.abc import Callable, Sequence
from math import degrees, pi, radians
from pathlib import Path

import numpy as np

from povgen.measure.plotting import Axes, Figure, save_drawing, style, withStroke
from povgen.optics import equations
from povgen.optics.prism import Prism
from povgen.paper import agreement
from povgen.paper.shapes import (
    GREY,
    RAY,
    SHEET,
    arc,
    arrow,
    coordinate_axes,
    entitle,
    faces,
    path,
    plane,
    point_at,
    projected,
    space,
    write,
    xy,
)
from povgen.record import save
from povgen.rendering.frames import read_png, render_all
from povgen.scene.presets import AxialScene, Chess, Spheres
from povgen.scene.scene import Scene
from povgen.scene.sdl import to_caption
from povgen.settings import AS_DRAWN, Print, Rendering
from povgen.video import overlay
from povgen.video.piece_outline import outlines

WIDTH = 7.0  # inches: two columns of a journal
PRINT = {"font.size": 10, "axes.titleweight": "normal", "axes.titlesize": 10, "figure.dpi": 200, "savefig.dpi": 200}
CONSTANT_ALPHA, CONSTANT_R, PREDICTED = "#0b5fa5", "#c1512d", "#c800ae"
VIEW = 2.9  # height of a frame, tiles


Captioned = tuple[Figure, dict[str, object]]  # a figure, and the data for its caption


def save_figure(
    number: int, folder: Path, rendering: Rendering, printed: Print = AS_DRAWN, pdf: bool = False
) -> list[Path]:
    """Write figure `number`, 1 to 6, and return the files: figureN.png, for a line drawing figureN.svg, and figureN.md.

    figureN.md is the caption. With `pdf` there is also figureN.pdf. By default a figure is 178 mm wide, at 200 dots an
    inch.
    """
    with style(**PRINT):
        figure, data = FIGURES[number](rendering)
        kinds = [".png", *[".svg"] * (number in LINES), *[".pdf"] * pdf]
        pictures = [folder / f"figure{number}{kind}" for kind in kinds]
        save_drawing(figure, *pictures, printed=printed)
    caption = folder / f"figure{number}.md"
    save(to_caption(number, data).encode(), caption)
    return [*pictures, caption]


def dove_prism_sheet(rendering: Rendering) -> Captioned:
    """Draw figure 1: a sheet in space, the real path of a ray, that of a mirrored ray, and the section of one prism."""
    count, half = 5, 1.7
    prism = Prism(1.0)
    height, half_base, half_top = prism.height, prism.length / 2, prism.top_length / 2
    ray = agreement.ray_through_sheet(count, 5.2)

    figure = Figure(figsize=(WIDTH, 2.8))
    ax = space(figure.add_axes((0.01, 0.0, 0.6, 1)))
    for n in range(count):
        y = n - count / 2
        profile = [(y, -half_base), (y, half_base), (y + height, half_top), (y + height, -half_top)]
        near, back = ([(x, *corner) for corner in profile] for x in (-half, half))
        passed = y <= ray.path[1][1] <= y + height  # the ray passes this prism
        shown = [back, *([near[k - 1], near[k], back[k], back[k - 1]] for k in range(4)), near]
        faces(ax, shown, "#9fc5e8" if passed else "#e3eef8", 0.5 if passed else 0.25)
    mirror = [(x, ray.crossing[1], z) for x, z in ((-half, -2.6), (half, -2.6), (half, 2.6), (-half, 2.6))]
    faces(ax, [mirror], "#999999", 0.35, edge=GREY)
    path(ax, [ray.crossing, ray.straight], GREY, 1.2, ":", head=True)
    mirrored = np.add(ray.crossing, 0.78 * np.subtract(ray.mirrored, ray.crossing))  # the other path's head is free
    path(ax, [ray.path[0], ray.crossing, mirrored], "black", 1.3, "--", head=True)
    path(ax, ray.path, RAY, 2.2, head=True)
    for place, number in zip(ray.path[1:4], "123", strict=True):
        write(ax, projected(place) + (-0.05, -0.28), number, fontweight="bold", fontsize=8)
    coordinate_axes(ax, (0.6, -3.3, 5.2))
    for end, text, up in ((ray.path[-1], "real path:\ndisplaced", -0.45), (mirrored, "mirrored", 0.22)):
        write(ax, projected(end) + (0.15, up), text, ha="left", fontsize=8)
    write(ax, projected(ray.straight) + (0.15, 0), "without\nthe sheet", ha="left", fontsize=8)
    left = projected((-half, 0, half_base))[0] - 0.2
    low, high = (projected((-half, count / 2 - n, half_base))[1] for n in (2, 1))
    ax.annotate("", (left, low), (left, high), arrowprops={"arrowstyle": "<->", "shrinkA": 0, "shrinkB": 0})
    write(ax, (left - 0.15, (low + high) / 2), "pitch", ha="right", fontsize=8)
    write(ax, projected((0, -count / 2, -half_base)) + (0.1, -0.25), "ridge", ha="left", fontsize=8)
    corner = projected((-half, ray.crossing[1], 2.6))
    write(ax, corner + (-0.1, 0.15), "mirror plane", ha="right", color=GREY, fontsize=8)
    _section(figure.add_axes((0.67, 0.0, 0.32, 1)), prism, ray)
    _letters(figure, (0.01, 0.92), (0.67, 0.92))
    return figure, {"ray": ray}


def _section(ax: Axes, prism: Prism, ray: agreement.RayThroughSheet) -> None:
    """Draw the section of the prism that the ray passes, and what happens to the ray at each of three faces."""
    space(ax)
    first, base, last = (np.array((-z, y)) for _, y, z in ray.path[1:4])
    low, half_base, half_top = base[1], prism.length / 2, prism.top_length / 2
    corners = [(-half_base, low), (half_base, low), (half_top, low + prism.height), (-half_top, low + prism.height)]
    ax.fill(*np.transpose(corners), facecolor="#cfe2f3", edgecolor=SHEET, linewidth=1.2)
    start, end = ((-z, y) for _, y, z in (ray.path[0], ray.path[-1]))
    before, after = (near + (far - near) * 0.75 / abs(far[0] - near[0]) for near, far in ((first, start), (last, end)))
    ax.plot(*np.transpose([before, first, base, last]), color=RAY, linewidth=2, solid_joinstyle="round")
    arrow(ax, (last[0], last[1]), (after[0], after[1]), RAY, 2)
    for place, number, aside in ((first, "1", (-0.2, 0.2)), (base, "2", (0, -0.24)), (last, "3", (0.2, 0.22))):
        ax.plot(*place, "o", color="black", markersize=4, zorder=3)
        write(ax, place + aside, number, fontweight="bold", fontsize=9)
    middle = (before[0] + after[0]) / 2
    text = "1, 3: refraction at the facets\n2: total reflection at the base\n$h$: height of a prism"
    write(ax, (middle, low - 0.5), text, va="top", ha="center", ma="left", fontsize=8, linespacing=1.5)
    side = after[0] + 0.2
    ax.annotate(
        "", (side, low), (side, low + prism.height), arrowprops={"arrowstyle": "<->", "shrinkA": 0, "shrinkB": 0}
    )
    write(ax, (side + 0.08, low + prism.height / 2), "$h$", ha="left", fontsize=10)
    ax.set(xlim=(before[0] - 0.1, side + 0.35), ylim=(low - 1.5, low + prism.height + 0.55))


def mirroring(rendering: Rendering) -> Captioned:
    """Draw figure 2: mirroring a picture about the vertical, then about an axis at alpha/2, rotates it by alpha."""
    alpha = radians(32)
    scene = Chess(sheet="none", z1=2.2, eye=(0, -0.58))
    picture = read_png(next(render_all([scene], rendering))[0])
    made = agreement.mirror_twice(picture, scene, alpha, rendering.size[1] // 2)

    figure = Figure(figsize=(WIDTH, 2.85), layout="constrained")
    figure.get_layout_engine().set(h_pad=0.08)  # type: ignore[union-attr, call-arg]
    panels = figure.subplots(1, 3)
    titles = ("a picture", "mirrored about the vertical", r"then about an axis at $\alpha/2$")
    for ax, panel, title in zip(panels, made.pictures, titles, strict=True):
        shown = ax.imshow(panel / 255, extent=(-1, 1, -1, 1))
        disc = 0.985 * np.exp(1j * np.linspace(0, 2 * pi, 241))
        shown.set_clip_path(ax.fill(*xy(disc), fill=False, linewidth=0.8)[0])
        ax.set(xlim=(-1.4, 1.4), ylim=(-1.4, 1.5), aspect="equal")
        ax.set_xlabel(title, fontsize=9)
        ax.tick_params(left=False, bottom=False, labelleft=False, labelbottom=False)
        ax.spines[:].set_visible(False)
    for n, (ax, up) in enumerate(zip(panels, (1j, 1j, 1j * np.exp(-1j * alpha)), strict=True)):
        entitle(ax, n)
        arrow(ax, xy(0.99 * up), xy(1.42 * up), RAY, 2)  # up, in the picture
    for ax, axis in zip(panels[1:], made.axes, strict=True):
        ax.plot(*xy(np.array([-1.3, 1]) * axis), "--", color="black", linewidth=1.3)
    panels[2].plot(*xy(np.array([-1.3, 1.42]) * made.axes[0]), ":", color="black", linewidth=1)
    arc(panels[2], 0, 1.2, pi / 2, pi / 2 - alpha, r"$\alpha$", 0.15)
    arc(panels[2], 0, 1.12, -pi / 2, -pi / 2 - alpha / 2, r"$\alpha/2$", 0.19)
    return figure, {"alpha": degrees(alpha), "made": made}


def vary_alpha(rendering: Rendering) -> Captioned:
    """Draw figure 3: frames of the alpha movie, with predicted images."""
    scenes = [Chess(alpha=alpha) for alpha in (0, 33, 66, 99, 132, 180)]
    figure, panels, measured = _compared(scenes, rendering, [_at_angle(scene) for scene in scenes])
    point_at(panels[0], (-0.15, -1.08), "stray light", (0.76, -1.27), size=14)
    point_at(panels[2], (0.42, -0.47), "predicted image", (0.4, -1.2), PREDICTED, 14)
    return figure, {"pieces": measured}


def vary_z1(rendering: Rendering) -> Captioned:
    """Draw figure 4: frames of the z1 movie. Insets magnify the piece of the last frames."""
    scenes = [Chess(alpha=90, z1=z1) for z1 in (1, 1.5, 3, 6, 15, 30)]
    titles = [f"$z_1$ = {z1:g} tile{'' if z1 == 1 else 's'}" for z1, *_ in (scene.distances for scene in scenes)]
    figure, panels, measured = _compared(scenes, rendering, titles)
    point_at(panels[2], (0.6, -0.48), "predicted image", (0.4, -1.2), PREDICTED, 14)
    half = 0.24
    for ax, scene in ((panels[n], scenes[-1].replace(sheet=sheet)) for n, sheet in ((5, "detailed"), (11, "ideal"))):
        inset = ax.inset_axes((0.6, 0.01, 0.39, 0.39))
        _draw_frames([inset], [scene.replace(view=2 * half)], rendering)
        inset.axis("on")
        inset.spines[:].set_visible(True)
        inset.set(xticks=[], yticks=[])
        ax.indicate_inset((-half, -half, 2 * half, 2 * half), inset, edgecolor="black", alpha=1)
        _outline(inset, scene)
    return figure, {"pieces": measured, "horizon": agreement.horizon_angle(90)}


def geometry(rendering: Rendering) -> Captioned:
    """Draw figure 5: a ray from L through P to E in space, its projection, and the circles on which P lies."""
    alpha, z1, z2 = radians(60), 1.3, 2.6
    figure = Figure(figsize=(WIDTH, 6.6))
    _geometry_in_space(space(figure.add_axes((0.03, 0.5, 0.94, 0.5))), alpha, z1, z2)
    _projection(figure.add_axes((0.01, 0.02, 0.41, 0.44)), z2 / z1, alpha)
    _circles(figure.add_axes((0.43, 0.005, 0.56, 0.46)), z2 / z1, alpha)
    _letters(figure, (0.02, 0.96), (0.02, 0.48), (0.45, 0.48))
    for x, y, text in (
        (0.08, 0.96, "a ray from the object to the eye"),
        (0.08, 0.48, "seen along z"),
        (0.51, 0.48, r"$P$ is where orange ($r = p_2/p_1$) crosses blue ($\alpha$)"),
    ):
        figure.text(x, y, text, fontsize=11)
    traced = agreement.trace_through_P(alpha, z1, z2)
    return figure, {"alpha": degrees(alpha), "traced": traced}


def spheres(rendering: Rendering) -> Captioned:
    """Draw figure 6: frames of the spheres movie, with predicted positions and the curve on which they lie."""
    scenes = [Spheres(alpha=alpha) for alpha in (0, 30, 60, 90, 120, 135)]
    near = [scene.replace(look=(-0.34, -0.45), view=1.7) for scene in scenes]
    figure, panels = _montage(near, rendering, [_at_angle(scene) for scene in scenes])
    point_at(panels[0], (-0.67, -0.86), "stray light", (-0.2, -1))
    cased = [withStroke(linewidth=2, foreground="white")]
    for ax, scene in zip(panels, scenes, strict=True):
        for line in overlay.loci(scene)[0][0]:
            for width, colour in ((2, "white"), (0.8, CONSTANT_ALPHA)):
                ax.plot(*xy(line), color=colour, linewidth=width)
        places = np.array(overlay.positions(scene))
        for size, colour in ((3.6, "white"), (2, "black")):
            ax.plot(*xy(places), "o", markersize=size, color=colour, markeredgewidth=0)
        for name, place, aside in (("L", scene.L, -0.1), ("E", scene.E, 0.15)):
            write(ax, xy(place + aside + 0.08j), f"${name}$", fontsize=12, path_effects=cased)
    for text, place in (("near", scenes[0].L), ("far", scenes[0].E)):
        write(panels[0], xy(place - 0.2j), text, fontsize=11, path_effects=cased)
    position = max(overlay.positions(scenes[3]), key=lambda z: z.real - z.imag)  # on the side of the text
    point_at(panels[3], xy(position), "predicted position", (-0.05, -1.17))
    curve = max(np.concatenate(overlay.loci(scenes[4])[0][0]), key=lambda z: z.real - z.imag)
    point_at(panels[4], xy(curve), "predicted at all $z_1$", (0.05, -1.17), CONSTANT_ALPHA)
    return figure, {"spheres": agreement.spheres(scenes)}


def _at_angle(each: AxialScene | agreement.PieceAgreement) -> str:
    return rf"$\alpha$ = {each.alpha:g}°"


FIGURES: dict[int, Callable[[Rendering], Captioned]] = {
    1: dove_prism_sheet,
    2: mirroring,
    3: vary_alpha,
    4: vary_z1,
    5: geometry,
    6: spheres,
}
LINES = 1, 2, 5  # line drawings, which are also saved as SVG


def _letters(figure: Figure, *places: tuple[float, float]) -> None:
    """Write (a), (b), ... at places of a figure, in parts of its width and height."""
    for n, (x, y) in enumerate(places):
        figure.text(x, y, f"({chr(97 + n)})", fontsize=12, fontweight="bold")


def _montage(scenes: Sequence[Scene], rendering: Rendering, titles: list[str]) -> tuple[Figure, Sequence[Axes]]:
    """Draw two rows of three frames, with coordinates in the plane z = 0. Return the figure and a panel for each scene.

    If there are twelve scenes, the last six are drawn in a row below each of the two rows.
    """
    ideal = len(scenes) > len(titles)
    figure = Figure(figsize=(WIDTH, 9.62 if ideal else 5.05))
    # the low row leaves room for titles
    heights = [1, 1, 0.17, 1, 1] if ideal else [1, 1]
    layout = {"left": 0.05 if ideal else 0.005, "right": 0.995, "top": 0.963 if ideal else 0.945, "bottom": 0.003}
    spaces = {"hspace": 0.03 if ideal else 0.13, "wspace": 0.03, "height_ratios": heights}
    grid = figure.add_gridspec(len(heights), 3, **layout, **spaces)
    rows = [[figure.add_subplot(grid[n, k]) for k in range(3)] for n, high in enumerate(heights) if high == 1]
    panels = [ax for row in (*rows[::2], *rows[1::2]) for ax in row] if ideal else [*rows[0], *rows[1]]
    _draw_frames(panels, scenes, rendering)
    for n, title in enumerate(titles):
        entitle(panels[n], n, title, 16 if ideal else 9)
    for row, text in zip(rows if ideal else (), ("prisms, measured", "ideal sheet, predicted") * 2, strict=ideal):
        row[0].text(-0.07, 0.5, text, transform=row[0].transAxes, rotation=90, ha="center", va="center", fontsize=13)
    return figure, panels


def _compared(
    scenes: Sequence[Chess], rendering: Rendering, titles: list[str]
) -> tuple[Figure, Sequence[Axes], Sequence[agreement.PieceAgreement]]:
    """Draw frames through prisms and, below them, through the ideal sheet, with nu, M and the outline of each piece."""
    measured = agreement.pieces(scenes)
    drawn = [scene.replace(view=VIEW, sheet=sheet) for sheet in ("detailed", "ideal") for scene in scenes]
    figure, panels = _montage(drawn, rendering, titles)
    said = [(each.nu, each.M) for each in measured] + [(each.nu_predicted, each.M_predicted) for each in measured]
    for ax, scene, (nu, M) in zip(panels, drawn, said, strict=True):
        _outline(ax, scene)
        box = {"facecolor": "white", "edgecolor": "none", "pad": 2, "alpha": 0.85}
        write(ax, (0, 0.435 * VIEW), rf"$\nu$ = {nu:z.1f}°, $M$ = {M:.2f}", fontsize=12, bbox=box)
    return figure, panels, measured


def _draw_frames(panels: Sequence[Axes], scenes: Sequence[Scene], rendering: Rendering) -> None:
    """Draw a square frame in each panel."""
    square = rendering.replace(size=(rendering.size[1],) * 2)
    for ax, scene, (frame,) in zip(panels, scenes, render_all(scenes, square), strict=True):
        (x, y, _), half = scene.camera.middle, scene.camera.height / 2
        ax.imshow(read_png(frame), extent=(x - half, x + half, y - half, y + half))
        ax.axis("off")


def _outline(ax: Axes, scene: Chess) -> None:
    """Draw the predicted outline of the piece."""
    points = outlines(scene, 0.005)
    for size, colour in ((2.4, "white"), (1.2, PREDICTED)):
        ax.plot(*xy(points), ".", markersize=size, markeredgewidth=0, color=colour)


def _geometry_in_space(ax: Axes, alpha: float, z1: float, z2: float) -> None:
    """Draw the ray from L through P to E, the sheet, and the projections into the sheet's plane."""
    L, E = -0.6 + 0.25j, 0.6 + 0.25j
    P = complex(equations.apparent_position(L, E, z1, z2, alpha))

    def at(point: complex, z: float) -> tuple[float, float, float]:
        return point.real, point.imag, z

    faces(ax, [[(x, y, 0) for x, y in ((-1.05, -0.75), (1.05, -0.75), (1.05, 0.75), (-1.05, 0.75))]], "#9fc5e8", 0.5)
    path(ax, [at(P, z1), at(P, -z2)], GREY, 0.9, "-.")
    for foot, z in ((L, z1), (E, -z2)):
        path(ax, [at(foot, z), at(foot, 0), at(P, 0)], GREY, 1.3, ":")
    for foot in (L, E):
        path(ax, [at(foot, 0), at(P, 0)], GREY, 1.6)
    path(ax, [at(L, z1), at(P, 0)], RAY, 2.2)
    path(ax, [at(P, 0), at(E, -z2)], RAY, 2.2, head=True)
    dots = [projected(at(L, z1)), projected(at(P, 0)), projected(at(E, -z2))]
    ax.plot(*np.transpose(dots), "o", color="black", markersize=4)
    for point, text, dx, dy in (
        (at(L, z1), "object $L$", -0.33, 0),
        (at(P, 0), "$P$", 0.02, -0.13),
        (at(E, -z2), "eye $E$", 0.02, -0.16),
        (at(L, z1 / 2), "$z_1$", 0, 0.1),
        (at(E, -z2 / 2), "$z_2$", 0, 0.1),
        (at((L + P) / 2, 0), "$p_1$", 0.09, 0.1),
        (at((E + P) / 2, 0), "$p_2$", 0.09, -0.06),
        (at(-0.1 + 0.6j, 0), "sheet", 0, 0),
    ):
        write(ax, projected(point) + (dx, dy), text, fontsize=11)
    for z, foot in ((z1, L), (-z2, E)):  # theta, between the perpendicular and the ray, at P
        upright, ray = (projected(at(point, z)) - projected(at(P, 0)) for point in (P, foot))
        start, end = (np.arctan2(*vector[::-1]) for vector in (upright, ray))
        end = start + (end - start + pi) % (2 * pi) - pi
        arc(ax, complex(*projected(at(P, 0))), 1.07 if z > 0 else 0.95, start, end, r"$\theta$", 0.13)
    coordinate_axes(ax, (-1.4, -0.95, 1.75), 0.45)


def _projection(ax: Axes, r: float, alpha: float) -> None:
    """Draw the triangle L = 0, P, E = 1 in the plane of the sheet, and the angles alpha and nu."""
    P = complex(equations.P(r, alpha))
    plane(ax, (-0.25, 1.25), (-0.62, 0.42))
    ax.plot(*xy(P * np.array([1, 1.6])), ":", color=GREY, linewidth=1.3)
    for start, end in ((0, P), (P, 1)):
        arrow(ax, xy(start), xy(end), RAY, 2.2)
    arc(ax, P, 0.2, float(np.angle(P)), float(np.angle(1 - P)), r"$\alpha$", 0.07)
    arc(ax, 1, 0.3, pi, pi + float(equations.nu(r, alpha)), r"$\nu$", 0.07)
    for point, text, offset in (
        (0, "$L$ = 0", -0.13 + 0.09j),
        (1, "$E$ = 1", 0.03 + 0.09j),
        (P, "$P$", -0.05 - 0.08j),
    ):
        ax.plot(*xy(point), "o", color="black", markersize=4)
        write(ax, xy(point + offset), text, fontsize=11)
    write(ax, xy(P / 2 - 0.06 - 0.06j), "$p_1$", color=RAY)
    write(ax, xy((1 + P) / 2 + 0.1 - 0.09j), "$p_2 = r\\,p_1$", color=RAY)


def _circles(ax: Axes, of_r: float, of_alpha: float) -> None:
    """Draw where P lies for constant r and for constant alpha, by eq. 7, and P for the values of the other panels."""
    plane(ax, (-1.15, 2.15), (-1.1, 1.1))
    turn = np.linspace(-pi, pi, 721)
    for r, text, place in ((1 / 2, "1/2", 1.95 + 0.58j), (1, "$r$ = 1", 0.27 - 1.03j), (2, "2", -0.92 + 0.58j)):
        P = equations.P(r, turn)
        ax.plot(*xy(np.where(abs(P) > 6, np.nan, P)), color=CONSTANT_R, linewidth=1.2)
        write(ax, xy(place), text, color=CONSTANT_R, fontsize=11)
    ratio = np.geomspace(1e-3, 1e3, 721)
    # beside each curve's name: r where the line from it ends, and its place
    for alpha, r, place in ((60, 0.75, 0.77 - 1.03j), (90, 0.65, 1.18 - 1.03j), (120, 0.45, 1.6 - 1.03j)):
        for signed, at in ((alpha, place), (-alpha, place.conjugate())):
            ax.plot(*xy(equations.P(ratio, radians(signed))), "--", color=CONSTANT_ALPHA, linewidth=1.2)
            text = rf"$\alpha$ = {signed}°" if signed == 60 else f"{signed}°".replace("-", "−")
            look = {"arrowstyle": "-", "color": GREY, "linewidth": 0.8, "shrinkB": 0}
            end = xy(equations.P(r, radians(signed)))
            ax.annotate(text, end, xy(at), ha="center", va="center", color=CONSTANT_ALPHA, fontsize=11, arrowprops=look)
    ax.plot((0, 1), (0, 0), "--", color=CONSTANT_ALPHA, linewidth=2.2, zorder=4)
    write(ax, (0.415, 0.1), "0°", color=CONSTANT_ALPHA, fontsize=11)
    example = complex(equations.P(of_r, of_alpha))
    for point, text, offset in ((0, "$L$", -0.13 - 0.13j), (1, "$E$", 0.13 - 0.13j), (example, "$P$", 0.13 - 0.13j)):
        ax.plot(*xy(point), "o", color="black", markersize=4, zorder=5)
        casing = [withStroke(linewidth=2, foreground="white")]
        write(ax, xy(point + offset), text, fontsize=11, zorder=5, path_effects=casing)
