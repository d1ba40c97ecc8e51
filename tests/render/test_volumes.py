"""Chess pieces as distance fields, which POV-Ray measures."""

import json
import lzma

import numpy as np
import pytest
from conftest import povgen, some

from povgen import InputError, PovrayError
from povgen.inputs.pieces import PIECES, PieceFile
from povgen.rendering import cache, povray, volumes


def stored(volume):
    """Return the stored distances, in voxels: (x, y, z)."""
    return ((volumes.decoded(volume.data).astype(float) - 128) / 127 * volume.most).transpose(2, 1, 0)


def points(volume):
    """Return the grid's points, tiles: (x, y, z, 3)."""
    return np.array(volume.place[:3]) + volume.place[3] * np.moveaxis(np.indices(volumes.GRID), 0, -1)


def volume(piece):
    return volumes.volumes({"it": piece})["it"]


def own(text):
    return volume(PieceFile("own.inc", f"#declare Piece = {text}\n"))


def test_a_sphere_has_its_distance():
    made = own("sphere { 0.4*y, 0.4 }")
    exact = (np.linalg.norm(points(made) - (0, 0.4, 0), axis=-1) - 0.4) / made.place[3]
    near = abs(exact) < 0.5
    assert near.sum() > 10000
    assert abs(stored(made) - exact)[near].max() < 0.02  # of a voxel: the surface is curved
    far = abs(exact) > 4
    assert (stored(made)[far] == made.most * np.sign(exact[far])).all()


def test_a_surface_through_points_of_the_grid_has_no_gap(monkeypatch):
    """A cube from 5 to 9. Where inside and outside meet, both points are within a voxel of the surface."""
    monkeypatch.setattr(volumes, "GRID", (15, 15, 15))
    lines = np.ndindex(3, 3, 3)  # axis, and the two numbers of the lines that meet the cube, from 6 on
    distance = volumes.distances(np.array([(axis, 6 + i, 6 + j, at) for axis, i, j in lines for at in (5.0, 9.0)]))
    inside = distance < 0
    assert inside.sum() == 27 and inside[6:9, 6:9, 6:9].all()
    for axis in range(3):
        change = np.diff(inside, axis=axis)
        one, other = (np.delete(abs(distance), end, axis)[change] for end in (0, -1))
        assert change.sum() == 18 and max(one.max(), other.max()) <= 1


def test_hollows_and_hidden_surfaces():
    """A slit is outside, though only along one axis it can be seen; parts that overlap have no surface between them."""
    made = own(
        "union { difference { box { <-0.4, 0, -0.4>, <0.4, 0.8, 0.4> } box { <-0.5, 0.3, -0.05>, <0.5, 0.5, 0.05> } }"
        " cylinder { 0, 1.2*y, 0.2 open } }"
    )
    distance, place = stored(made), points(made)

    def at(*point):
        return distance[np.unravel_index(np.linalg.norm(place - point, axis=-1).argmin(), volumes.GRID)]

    assert at(0.3, 0.4, 0) > 0  # in the slit
    assert at(0, 0.6, 0) < -1.9 and at(0.2, 0.6, 0) < -1.9  # the cylinder's side is hidden in the box
    assert at(0.3, 0.4, 0.1) < -1.9


def test_a_pyramid_has_its_slanted_walls():
    """POV-Ray's prism that ends in a point: lines exactly along its axis would miss them."""
    square = "<-1, -1>, <1, -1>, <1, 1>, <-1, 1>, <-1, -1>"
    made = own(f"prism {{ conic_sweep linear_spline 0, 1, 5, {square} rotate 180*x translate y scale <0.4, 1, 0.4> }}")
    x, y, z = np.moveaxis(points(made), -1, 0)
    depth = np.minimum(0.4 * (1 - y) - np.maximum(abs(x), abs(z)), y)  # below the nearest wall, tiles
    clear = abs(depth) > made.place[3]
    assert ((stored(made) < 0) == (depth > 0))[clear].all() and (depth > 0)[clear].sum() > 1000


@pytest.mark.parametrize("piece", some([*PIECES], 2))
def test_pieces_are_solid(piece):
    """A piece's field has no single points that differ from all around them, as missed surfaces would leave."""
    inside = stored(volume(piece)) < 0
    assert 20000 < inside.sum() < 200000
    around = np.zeros(inside.shape, int)
    for axis in range(3):
        around += np.roll(inside, 1, axis).astype(int) + np.roll(inside, -1, axis)
    assert (inside & (around == 0)).sum() + (~inside & (around == 6)).sum() == 0


@pytest.mark.release
def test_shipped_fields_are_those_that_povray_measures(tmp_path):
    """If not: make povgen/rendering/volumes.xz. Another POV-Ray may round a distance to the next byte."""
    volumes.ship(tmp_path / "volumes.xz")
    shipped, measured = (json.loads(lzma.open(path).read()) for path in (volumes.SHIPPED, tmp_path / "volumes.xz"))
    assert shipped.keys() == measured.keys() and len(shipped) == len(PIECES)
    for key, values in shipped.items():
        one, other = (volumes.Volume(**each) for each in (values, measured[key]))
        np.testing.assert_allclose(one.place, other.place, atol=1e-9)
        assert abs(stored(one) - stored(other)).max() < 1.01 * volumes.MOST / 127


def test_povgens_own_pieces_need_no_povray(monkeypatch):
    monkeypatch.setattr(povray, "version", lambda: pytest.fail("POV-Ray was asked for"))
    assert [*volumes.volumes({name: name for name in PIECES})] == [*PIECES]


def test_a_field_is_kept_in_the_cache(monkeypatch):
    made = own("sphere { 0.3*y, 0.3 }")
    monkeypatch.setattr(povray.Runner, "run", lambda *_: pytest.fail("POV-Ray ran again"))
    assert own("sphere { 0.3*y, 0.3 }") == made


def test_the_cache_of_fields(monkeypatch, tmp_path):
    """A damaged field is measured again. No field is kept above the cache's limit, or in a folder of another."""
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path / "cache"))
    pieces = {"own": PieceFile("own.inc", "#declare Piece = sphere { 0.3*y, 0.3 }\n"), "king": "king"}
    made = volumes.volumes(pieces)
    ((_, _, kept),) = cache.by_last_use()
    assert povgen(["cache", "info"], tmp_path)[1].startswith("0 frames, 1 ray traces and pieces, ")
    whole = kept.read_bytes()
    kept.write_bytes(whole[:-9])
    assert volumes.volumes(pieces) == made and kept.read_bytes() == whole
    monkeypatch.setenv("POVGEN_CACHE_SIZE", "0")
    assert volumes.volumes(pieces) == made and not kept.exists()
    monkeypatch.setenv("POVGEN_CACHE", str(tmp_path))
    monkeypatch.setattr(povray.Runner, "run", lambda *_: pytest.fail("POV-Ray ran before the cache was checked"))
    with pytest.raises(InputError, match="POVGEN_CACHE = "):
        volumes.volumes(pieces)


@pytest.mark.parametrize(
    "nothing_solid",
    some(
        [
            "disc { 0.5*y, <0.3, 0.2, 1>, 0.4 }",
            "sphere { 3*x, 0 }",
            "triangle { x/3, y, -x/3 }",
            "box { -0.4, <0.4, 1, -0.399> }",
        ],
        1,
    ),
)
def test_an_empty_piece_is_refused(nothing_solid):
    with pytest.raises(InputError, match="'own.inc': no solid part thicker than"):
        own(nothing_solid)


def test_a_piece_with_too_many_surfaces_is_refused(monkeypatch):
    monkeypatch.setattr(volumes, "MAX_CROSSINGS", 1 << 16)
    with pytest.raises(InputError, match="'own.inc': too many surfaces"):
        own("sphere { 0.35*y, 0.35 }")


@pytest.mark.parametrize(
    ("text", "timeout", "said"),
    [
        ("sphere { 0, 0.3 }\n\nsphere { 0 }", 100, r"^POV-Ray: 'ow\\x1bn.inc', line 3: Expected"),
        ("sphere { 0, 0.3 } #while (1) #end", 0.5, r"took longer than 0.5 s \(--timeout\)"),
    ],
)
def test_an_error_names_the_piece_and_its_line(text, timeout, said):
    with pytest.raises(PovrayError, match=said) as error:
        volumes.volumes({"it": PieceFile("ow\x1bn.inc", f"#declare Piece = {text}\n")}, timeout=timeout)
    assert str(error.value).endswith("\n  in the shape of the piece 'ow\\x1bn.inc'")
