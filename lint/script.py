"""An ordinary script that uses povgen. `make lint` checks its types without plugins; it is never run.

The lines with `type: ignore` are wrong on purpose. If mypy did not find the fault, it would call the comment unused.
"""

from pathlib import Path

import numpy as np

from povgen import (
    Bundle,
    Chess,
    Eye,
    InputError,
    Movie,
    MovieSpec,
    Rendering,
    Room,
    Sphere,
    Spheres,
    Window,
    cheapest,
    live,
    movie,
    points,
    render,
    results,
    save,
    show,
    to_pov,
)

scene = Chess(alpha=66, z1=2, z2=6, sheet="ideal", predicted_image=True)
two = Chess(x=[-0.6, 0.6], z1=[2, 5], piece=["knight", "king"], color=("red", "blue"), eye=(0, 0.3))
spheres = Spheres(z1=np.array([2.0, 5.0]), line=0.3 + 0.2j)
windows = Chess(window=[{"alpha": 120, "z": 2}], z2=8, alpha=120)
law = Chess(sheet="law", law="x - k*X*z, y, z", parameter={"k": 0.3}, window="z=2,sheet=none")
turned = scene.replace(alpha=90)
alphas: list[float | None] = [turned.alpha, windows.window[0].alpha]
room = Room([Window(alpha=90), Sphere(z=2)], eye=Eye(z=-6), fresnel=True)
Room(Window(), wavelenth=500)  # type: ignore[call-arg]
room.replace(fresnell=True)  # type: ignore[call-arg]
Chess(alhpa=3)  # type: ignore[call-arg]
Chess(fresnel=3)  # type: ignore[arg-type]
scene.replace(alpa=3)  # type: ignore[call-arg]
scene.replace(alpha=3).nonsense()  # type: ignore[attr-defined]
print(windows.window[0].alpa)  # type: ignore[union-attr]
height: int = render(scene, quality="draft").shape[0]
heights: list[int] = [each.shape[0] for each in render([scene, turned], size=(64, 48), workers=2)]
render(scene, qualty="draft")  # type: ignore[call-overload]
show(scene, size="640x480").save("shown.png")
path: Path = save(scene, "frame.png", quality="high", antialias="2x", caption="full")
save(scene, "frame.png", qualty="high")  # type: ignore[call-arg]
text: str = to_pov(scene)
made: Movie = movie("vary-alpha", "alpha.mp4", quality="draft")
movie((scene.replace(z2=z2) for z2 in (6, 7, 8)), Path("away.gif"), frame_rate=5, antialias=(1, 0.1, 2))
rendering = Rendering(size=(64, 48), antialias="off")
Rendering(sice=(64, 48))  # type: ignore[call-arg]
rendering.replace(sice=(64, 48))  # type: ignore[call-arg]
count: int = len(MovieSpec.load("vary-alpha").scenes("draft"))
live(scene).save("view.html")
mean: float = float(results([scene, turned], "nu", "M")["nu"].mean())
share: float = float(scene.trace(scene.rays((64, 48))).designed.mean())
spot: complex = scene.spot((0, 0, 2), -2, 1000).centre
z: float = scene.trace(Bundle((0, 0, -6), [(0.1, 0, 1)])).convergence().z
drawn, options = cheapest(scene, "1px", renderer="auto")
render(drawn, **options)
render(drawn, renderer="auto")  # type: ignore[call-overload]
depth = points(scene, (64, 48))[..., 2]
try:
    Chess(alpha=400)
except InputError as error:
    print(error)
