// What stands in the scene, and where a ray meets it. Lengths are in tiles.
//
// A piece is a distance field, made from its own text in POV-Ray's language (povgen/rendering/volumes.py): a 3D texture
// of the distance to the piece's surface, in voxels, below 0 inside.

const int SKY = 0;
const int FLOOR = 1;
const int WINDOW_FRAME = 2;
const int OBJECT = 3;  // the first piece or sphere; the next is 4, and so on; the pieces' pedestals follow

uniform float window;                  // side of the square windows
uniform float windowZ[WINDOWS];        // z of the middle of each window, the nearest to the eye first
uniform float frameDepth;              // extent of a window frame along z
uniform float frameRim;                // width of a frame's sides
uniform bool hasFloor;
uniform float floorY;
uniform float horizon;                 // how far away the floor ends
#if PIECES > 0
uniform sampler3D volumes;             // the distance fields, side by side
uniform vec3 pieceFoot[PIECES];        // centre of the foot
uniform float pedestal;                // height of the pedestals; 0: none
uniform float pedestalHalf[PIECES];    // half the width of each
uniform int pieceVolume[PIECES];       // number of the piece's distance field
uniform vec4 volumePlace[VOLUMES];     // voxel 0, from the foot's centre; and the side of a voxel
#endif
#if SPHERES > 0
uniform vec4 spheres[SPHERES];         // centre and radius
#endif

struct Hit {
  float t;      // how far along the ray; the direction is a unit vector
  int what;     // SKY, FLOOR, WINDOW_FRAME, or OBJECT + the number of the object
  vec3 normal;  // unit vector, towards the ray's start
};

// When a ray enters and leaves a box.
vec2 boxed(vec3 o, vec3 d, vec3 lower, vec3 upper) {
  vec3 a = (lower - o) / d, b = (upper - o) / d;
  vec3 least = min(a, b), most = max(a, b);
  return vec2(max(max(least.x, least.y), least.z), min(min(most.x, most.y), most.z));
}

// A face of the frame's four sides. In the cross-section it runs from a to b: distance from the window's centre, and z.
void meetFrameFace(vec3 o, vec3 d, vec2 a, vec2 b, inout Hit hit) {
  vec2 across = normalize(vec2(b.y - a.y, a.x - b.x));
  for (int side = 0; side < 4; side++) {
    vec2 w = side == 0 ? vec2(1, 0) : side == 1 ? vec2(0, 1) : side == 2 ? vec2(-1, 0) : vec2(0, -1);  // to this side
    vec2 start = vec2(dot(w, o.xy), o.z), step = vec2(dot(w, d.xy), d.z);
    float t = dot(across, a - start) / dot(across, step);
    if (t > 0.0 && t < hit.t) {
      vec2 place = start + t * step, low = min(a, b), high = max(a, b);
      bool within = high.x - low.x > high.y - low.y
        ? place.x >= low.x && place.x <= high.x
        : place.y >= low.y && place.y <= high.y;
      float aside = abs(dot(w.yx, o.xy + t * d.xy));  // the sides' ends are mitred
      if (within && aside <= place.x) {
        vec3 normal = vec3(across.x * w, across.y);
        hit = Hit(t, WINDOW_FRAME, dot(normal, d) > 0.0 ? -normal : normal);
      }
    }
  }
}

// The frame of a window in the plane z = 0.
void meetFrame(vec3 o, vec3 d, inout Hit hit) {
  // A ray that comes through the opening can only meet the opening's four inner faces.
  float half_ = window / 2.0;
  float entry = max(((d.z > 0.0 ? -frameDepth : frameDepth) / 2.0 - o.z) / d.z, 0.0);
  vec3 place = o + entry * d;
  if (max(abs(place.x), abs(place.y)) <= half_) {
    vec2 reach = (sign(d.xy) * half_ - o.xy) / d.xy;
    float t = d.x == 0.0 || reach.y < reach.x ? reach.y : reach.x;
    if (t < hit.t && t >= entry && abs(o.z + t * d.z) < frameDepth / 2.0) {
      hit = Hit(t, WINDOW_FRAME, t == reach.y ? vec3(0, -sign(d.y), 0) : vec3(-sign(d.x), 0, 0));
    }
    return;
  }
  float back = frameDepth / 2.0, slant = min(frameRim, frameDepth);
  vec3 corner = vec3(vec2(half_ + frameRim), back);
  vec2 reach = boxed(o, d, -corner, corner);
  if (reach.x > reach.y || reach.y < 0.0 || reach.x > hit.t) return;
  // the cross-section's corners, from the opening's front to its back: distance from the opening, and z (templates/frame.pov.j2)
  vec2 section[6] = vec2[](
    vec2(0, -back), vec2(0.6 * frameRim, -back), vec2(0.75 * frameRim, 0.25 * slant - back), vec2(frameRim, 0.5 * slant - back),
    vec2(frameRim, back), vec2(0, back));
  vec2 centre = vec2(half_, 0);
  for (int k = 1; k < 6; k++) meetFrameFace(o, d, centre + section[k - 1], centre + section[k], hit);
}

void meetFrames(vec3 o, vec3 d, inout Hit hit) {
  meetFrame(o, d, hit);
#if WINDOWS > 1  // a loop without turns would take time
  for (int w = 1; w < WINDOWS; w++) meetFrame(o - vec3(0, 0, windowZ[w]), d, hit);
#endif
}

#if PIECES > 0
// The distance to a piece's surface, in voxels. q is in voxels from voxel 0.
float fieldAt(vec3 q, int volume) {
  const vec3 size = vec3(GRID);
  vec3 row = vec3(volume % 3, 0, volume / 3) * size;
  vec3 all = size * vec3(min(VOLUMES, 3), 1, (VOLUMES + 2) / 3);
  return textureLod(volumes, (clamp(q, vec3(0), size - 1.0) + row + 0.5) / all, 0.0).r;
}

vec3 fieldNormal(vec3 q, int volume) {
  const vec2 e = vec2(0.5, 0);
  return normalize(vec3(
    fieldAt(q + e.xyy, volume) - fieldAt(q - e.xyy, volume),
    fieldAt(q + e.yxy, volume) - fieldAt(q - e.yxy, volume),
    fieldAt(q + e.yyx, volume) - fieldAt(q - e.yyx, volume)));
}

// Return how far along the ray a piece's surface is, or `most` if the ray does not meet it before. Each step is as long as the
// distance to the surface; the last two points, on both sides of the surface, are interpolated.
float reachOf(int piece, vec3 o, vec3 d, float most) {
  int volume = pieceVolume[piece];
  vec4 place = volumePlace[volume];
  float voxel = place.w;
  vec3 start = (o - pieceFoot[piece] - place.xyz) / voxel, step = d / voxel;
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

void meetBox(vec3 o, vec3 d, vec3 lower, vec3 upper, int what, inout Hit hit) {
  vec2 reach = boxed(o, d, lower, upper);
  if (reach.x >= reach.y || reach.x <= 0.0 || reach.x >= hit.t) return;
  vec3 place = (o + reach.x * d - (lower + upper) / 2.0) / (upper - lower);
  vec3 far = abs(place);
  vec3 normal = far.x > max(far.y, far.z) ? vec3(1, 0, 0) : far.y > far.z ? vec3(0, 1, 0) : vec3(0, 0, 1);
  hit = Hit(reach.x, what, normal * sign(place));
}

// pedestal.pov.j2: a base, a block and a cap. The formulas of their sizes are in materials.glsl.
float PlinthShaft(float H);
float PlinthBase(float Pedestal);
float PlinthCap(float Pedestal);

void meetPedestal(int k, vec3 o, vec3 d, inout Hit hit) {
  vec3 foot = vec3(pieceFoot[k].x, floorY, pieceFoot[k].z);
  float wide = pedestalHalf[k], narrow = PlinthShaft(wide);
  vec2 reach = boxed(o, d, foot - vec3(wide, 0, wide), foot + vec3(wide, pedestal, wide));
  if (pedestal == 0.0 || reach.x > reach.y || reach.y < 0.0 || reach.x > hit.t) return;
  int what = OBJECT + PIECES + k;
  float base = PlinthBase(pedestal), cap = pedestal - PlinthCap(pedestal);
  meetBox(o, d, foot - vec3(wide, 0, wide), foot + vec3(wide, base, wide), what, hit);
  meetBox(o, d, foot + vec3(-narrow, base, -narrow), foot + vec3(narrow, cap, narrow), what, hit);
  meetBox(o, d, foot + vec3(-wide, cap, -wide), foot + vec3(wide, pedestal, wide), what, hit);
}
#endif

#if SPHERES > 0
float reachOfSphere(int k, vec3 o, vec3 d, float most) {
  vec3 centre = spheres[k].xyz - o;
  float nearest = dot(centre, d), radius = spheres[k].w;
  vec3 aside = centre - nearest * d;
  float square = radius * radius - dot(aside, aside);
  float t = nearest - sqrt(max(square, 0.0));
  return square > 0.0 && t > 0.0 && t < most ? t : most;
}
#endif

// The first surface that a ray meets. For the sky, t is infinite.
Hit meet(vec3 o, vec3 d) {
  Hit hit = Hit(1e30, SKY, vec3(0));
  float below = (floorY - o.y) / d.y;
  if (hasFloor && d.y < 0.0 && below > 0.0 && below < horizon) hit = Hit(below, FLOOR, vec3(0, 1, 0));
  meetFrames(o, d, hit);
#if PIECES > 0
  for (int k = 0; k < PIECES; k++) {
    meetPedestal(k, o, d, hit);
    float t = reachOf(k, o, d, hit.t);
    if (t < hit.t) {
      vec4 place = volumePlace[pieceVolume[k]];
      hit = Hit(t, OBJECT + k, fieldNormal((o + t * d - pieceFoot[k] - place.xyz) / place.w, pieceVolume[k]));
    }
  }
#endif
#if SPHERES > 0
  for (int k = 0; k < SPHERES; k++) {
    float t = reachOfSphere(k, o, d, hit.t);
    if (t < hit.t) hit = Hit(t, OBJECT + k, (o + t * d - spheres[k].xyz) / spheres[k].w);
  }
#endif
  return hit;
}

// Whether something stands between a point and a light in this direction. The floor never does, nor does glass.
bool shadowed(vec3 o, vec3 d) {
  Hit hit = Hit(1e30, SKY, vec3(0));
  meetFrames(o, d, hit);
#if PIECES > 0
  for (int k = 0; k < PIECES; k++) meetPedestal(k, o, d, hit);
#endif
  if (hit.what != SKY) return true;
#if PIECES > 0
  for (int k = 0; k < PIECES; k++) if (reachOf(k, o, d, 1e30) < 1e30) return true;
#endif
#if SPHERES > 0
  for (int k = 0; k < SPHERES; k++) if (reachOfSphere(k, o, d, 1e30) < 1e30) return true;
#endif
  return false;
}
