"""A chess piece: povgen's own, or a user's from a file."""

from pydantic import Field

from povgen.inputs.fields import Colour, PieceValue
from povgen.inputs.pieces import PIECES, PieceFile, radius
from povgen.objects.placed import Extent
from povgen.objects.scene_object import SceneObject
from povgen.optics.pose import Floats


class Piece(SceneObject):
    """A chess piece of wood. Its place is the centre of its foot."""

    kind = "piece"
    title = "chess piece"
    point_is = "foot"

    piece: PieceValue = Field(
        default="knight",
        description=f"the chess piece: {', '.join(PIECES)}, or a file that declares Piece, or a mesh",
    )
    color: Colour = Field(default="#e7b56f", description="colour of the wood: a name, or a code such as #c87529")

    declarations = (
        '{% include "piece_wood.pov.j2" %}',
        """{% if each.piece is not file %}
{% include "pieces/" ~ each.piece ~ ".pov.j2" %}
#declare {{ each.piece.capitalize() }}Piece = object { Piece }
{% endif %}""",
    )
    sdl = """object {
  {{ "OwnPiece_%d" % (own.index(each.piece) + 1) if each.piece is file else each.piece.capitalize() ~ "Piece" }}
  Wood(<{{ "%.4g, %.4g, %.4g" % each.colour }}>)
}"""
    # A distance field, made from the piece's text in POV-Ray's language (povgen/rendering/volumes.py): a 3D texture of
    # the distance to the surface, in voxels, below 0 inside. n.x is the field's number.
    glsl = """
#if VOLUMES > 0
uniform sampler3D volumes;           // the distance fields, side by side
uniform vec4 volumePlace[VOLUMES];   // voxel 0, from the foot's centre; and the side of a voxel

// The distance to a piece's surface, in voxels. q is in voxels from voxel 0.
float fieldAt(vec3 q, int volume) {
  const vec3 size = vec3(GRID);
  vec3 row = vec3(volume % 3, 0, volume / 3) * size;
  vec3 all = size * vec3(min(VOLUMES, 3), 1, (VOLUMES + 2) / 3);
  return textureLod(volumes, (clamp(q, vec3(0), size - 1.0) + row + 0.5) / all, 0.0).r;
}

vec3 normal_piece(vec3 p, vec4 n) {
  const vec2 e = vec2(0.5, 0);
  int volume = int(n.x);
  vec3 q = (p - volumePlace[volume].xyz) / volumePlace[volume].w;
  return normalize(vec3(
    fieldAt(q + e.xyy, volume) - fieldAt(q - e.xyy, volume),
    fieldAt(q + e.yxy, volume) - fieldAt(q - e.yxy, volume),
    fieldAt(q + e.yyx, volume) - fieldAt(q - e.yyx, volume)));
}

// Each step is as long as the distance to the surface; the last two points, on both sides of it, are interpolated.
float reach_piece(vec3 o, vec3 d, vec4 n, float most) {
  int volume = int(n.x);
  vec4 place = volumePlace[volume];
  float voxel = place.w;
  vec3 start = (o - place.xyz) / voxel, step = d / voxel;
  vec2 range = boxed(start, step, vec3(0.5), vec3(GRID) - 1.5);
  range = vec2(max(range.x, 0.0), min(range.y, most));
  if (range.x >= range.y) return most;
  float t = range.x, before = t, gap = 0.0;
  for (int k = 0; k < 160 && t < range.y; k++) {
    float s = fieldAt(start + t * step, volume);
    if (s <= 0.0) return k == 0 ? t : mix(before, t, gap / (gap - s));
    before = t;
    gap = s;
    t += max(s, 0.2) * voxel;
  }
  return most;
}
Finish finish_piece(vec3 p, vec4 n, vec3 colour) { return Wood(colour, p); }
#endif
"""

    @property
    def box(self) -> Extent:
        """The room that it takes. Of a piece from a file only the foot is known."""
        r = radius(self.shape)
        top = 0.05 if isinstance(self.shape, PieceFile) else PIECES[self.shape]["height"]
        return (-r, 0, -r), (r, top, r)

    @property
    def called(self) -> str:
        return self.kind if isinstance(self.shape, PieceFile) else self.shape

    @property
    def point(self) -> Floats:
        return self.pose.place

    @property
    def shape(self) -> str | PieceFile:
        assert isinstance(self.piece, (str, PieceFile))
        return self.piece
