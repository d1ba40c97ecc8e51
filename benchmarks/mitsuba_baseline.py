"""Render the sheets of povgen's detailed frame with Mitsuba 3, and time it.

mitsuba_points.py runs this in an environment of its own. The arguments are a variant of Mitsuba, the greatest number of
faces on a path, the picture's width and height, the rays a pixel, and a file for the picture (.npy, sRGB bytes).
Standard input is JSON: lengths of povgen's scene, in tiles (the window's side, the picture's height, z2, the floor's
height), and the mesh, a list of sheets, each a list of triangles of three corners. The output is the CPU seconds of
rendering, of all threads, without reading the scene: the median of three frames, after one to warm up.
"""

import json
import sys
import time

import mitsuba as mi
import numpy as np

VARIANT, FACES, WIDTH, HEIGHT, RAYS, PICTURE = sys.argv[1:]
mi.set_variant(VARIANT)


def sheet(triangles: list) -> "mi.Mesh":
    corners = np.array(triangles, np.float32).reshape(-1, 3)
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict({"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0})
    mesh = mi.Mesh("sheet", len(corners), len(corners) // 3, props=properties)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = corners.ravel()
    parameters["faces"] = np.arange(len(corners), dtype=np.uint32)
    parameters.update()
    return mesh


def main() -> None:
    given = json.load(sys.stdin)
    window, z2 = given["window"], given["z2"]
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": int(FACES)},
        "light": {"type": "constant", "radiance": 0.8},
        "floor": {
            "type": "rectangle",
            "to_world": mi.ScalarTransform4f().translate([0, given["floor"], 0]).rotate([1, 0, 0], -90).scale(200),
            "bsdf": {
                "type": "diffuse",
                "reflectance": {"type": "checkerboard", "to_uv": mi.ScalarTransform4f().scale([200, 200, 1])},
            },
        },
        "sensor": {
            "type": "perspective",
            "fov_axis": "y",
            "fov": float(2 * np.degrees(np.arctan(given["view"] / 2 / z2))),
            "to_world": mi.ScalarTransform4f().look_at(origin=[0, 0, -z2], target=[0, 0, 0], up=[0, 1, 0]),
            "film": {"type": "hdrfilm", "width": int(WIDTH), "height": int(HEIGHT), "rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": int(RAYS)},
        },
    }
    # in place of the window frame, four boxes around the window stop all rays beside it
    side, middle = 3.0, window / 2 + 3.0 / 2
    for n, (x, y) in enumerate(((middle, 0), (-middle, 0), (0, middle), (0, -middle))):
        half = [side / 2, 3.0, 0.13] if x else [window / 2, side / 2, 0.13]
        scene[f"frame{n}"] = {"type": "cube", "to_world": mi.ScalarTransform4f().translate([x, y, 0]).scale(half)}
    for n, triangles in enumerate(given["sheets"]):
        scene[f"sheet{n}"] = sheet(triangles)
    loaded = mi.load_dict(scene)
    seconds = []
    for seed in range(4):
        start = time.process_time()
        light = np.array(mi.render(loaded, seed=seed))  # waits until all is drawn
        seconds.append(time.process_time() - start)
    np.save(PICTURE, np.array(mi.Bitmap(light).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, True)))
    print(sorted(seconds[1:])[1])


if __name__ == "__main__":
    main()
