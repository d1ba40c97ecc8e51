// The ray trace through sheets of Dove prisms, as in povgen/optics/trace.py.
//
// A ray is kept in the coordinates of the prism that it is at: the number `cell` of the prism, and the height u above
// its base, in units of the pitch. So 32-bit numbers are precise enough for any number of prisms.

const int THROUGH = 0;     // leaves on the side that it did not come from
const int BACK = 1;        // leaves on the side that it came from
const int FRAME = 2;       // meets the window frame
const int UNFINISHED = 3;  // has met the greatest allowed number of faces

uniform int sheets;             // how many: 1 or 2
uniform vec2 sheetTurn[2];      // cosine and sine of each sheet's angle
uniform float sheetCentre[2];   // z of each sheet's middle plane, tiles
uniform float pitch;            // from one prism to the next, tiles
uniform float firstBase;        // y of the base of prism 0, in pitches
uniform float prismHeight;      // from base to top, in pitches
uniform float prismHalf;        // half of the length along z, in pitches
uniform vec2 slant;             // cosine and sine of the base angle
uniform float glassIndex;
uniform int maxFaces;           // as POV-Ray's max_trace_level: a ray that meets as many is dark

struct Passage {
  vec3 position;   // where the ray leaves the sheets, or meets the window frame, tiles
  vec3 direction;  // unit vector
  int end;
  int faces;       // how many faces it has met
  float path;      // the first nine faces, each a digit to the base 5: 1 base, 2 top, 3 near, 4 far
};

// Follow a ray that comes to the sheets from outside. `origin` is any point of its line. The direction is a unit vector.
Passage passage(vec3 origin, vec3 direction) {
  const float FAR = 1e30;
  float halfWindow = window / 2.0 / pitch;
  bool forward = direction.z > 0.0;
  int at = forward ? 0 : sheets - 1;
  vec3 p = origin / pitch;  // in the scene's axes while the ray is between sheets; in the sheet's, with u for y, inside
  vec3 d = direction;
  float cell = 0.0;
  vec2 turn = vec2(1, 0);
  bool between = true, glass = false;
  float digit = 1.0;
  Passage ray = Passage(origin, direction, UNFINISHED, 0, 0.0);

  for (int step = 0; step < 400; step++) {  // maxFaces ends it earlier
    if (between) {
      if (at < 0 || at >= sheets) {
        ray.end = ((at > 0) == forward) ? THROUGH : BACK;
        break;
      }
      float surface = d.z > 0.0 ? -prismHalf : prismHalf;
      p += d * ((surface + sheetCentre[at] / pitch - p.z) / d.z);
      if (max(abs(p.x), abs(p.y)) > halfWindow) {
        ray.end = FRAME;
        break;
      }
      turn = sheetTurn[at];
      float v = turn.x * p.y - turn.y * p.x - firstBase;
      cell = floor(v);
      p = vec3(turn.x * p.x + turn.y * p.y, v - cell, surface);
      d.xy = vec2(turn.x * d.x + turn.y * d.y, turn.x * d.y - turn.y * d.x);
      between = false;
    }
    if (abs(d.y) < 1e-12) d.y = 1e-12;

    // The four planes of a prism: how fast the ray approaches the slanted ones from inside, and when it meets each.
    bool up = d.y > 0.0;
    float level = ((up ? prismHeight : 0.0) - p.y) / d.y;
    vec2 along = vec2(slant.x * d.y - slant.y * d.z, slant.x * d.y + slant.y * d.z);
    vec2 reach = (slant.y * prismHalf - vec2(slant.x * p.y - slant.y * p.z, slant.x * p.y + slant.y * p.z)) / along;
    float t;
    int face;
    if (glass) {
      t = level;
      face = up ? 2 : 1;
      if (along.x > 0.0 && reach.x < t) { t = reach.x; face = 3; }
      if (along.y > 0.0 && reach.y < t) { t = reach.y; face = 4; }
      t = max(t, 0.0);
    } else {
      float first = up ? (p.y > prismHeight ? FAR : -FAR) : (prismHeight - p.y) / d.y;
      float last = level;
      face = 2;
      if (along.x > 0.0) last = min(last, reach.x);
      else if (reach.x > first) { first = reach.x; face = 3; }
      if (along.y > 0.0) last = min(last, reach.y);
      else if (reach.y > first) { first = reach.y; face = 4; }
      t = first > -1e-6 && first < last && last >= 0.0 ? max(first, 0.0) : FAR;
      float base = up ? max((1.0 - p.y) / d.y, 0.0) : FAR;  // of the prism above
      if (base < t) { t = base; face = 1; }
      float side = max(((d.z > 0.0 ? prismHalf : -prismHalf) - p.z) / d.z, 0.0);
      if (side <= t) { t = side; face = 0; }  // leaves the sheet
    }

    // Move on. Inside the window frame the ray ends, where it met the frame's inner faces.
    p += t * d;
    float y = p.y + cell + firstBase;
    vec2 place = vec2(turn.x * p.x - turn.y * y, turn.y * p.x + turn.x * y);
    vec2 beyond = abs(place) - halfWindow;
    if (face == 0 || max(beyond.x, beyond.y) > 0.0) {
      d.xy = vec2(turn.x * d.x - turn.y * d.y, turn.y * d.x + turn.x * d.y);
      p = vec3(place, p.z + sheetCentre[at] / pitch);
      if (max(beyond.x, beyond.y) > 0.0) {
        vec2 back = max(beyond / max(abs(d.xy), 1e-9), 0.0);
        p -= d * min(max(back.x, back.y), t);
        ray.end = FRAME;
        break;
      }
      between = true;
      at += d.z > 0.0 ? 1 : -1;
      continue;
    }

    // Refract the ray, or reflect it totally. `cosine` is positive for a ray that leaves the prism.
    vec2 normal = face == 1 ? vec2(-1, 0) : face == 2 ? vec2(1, 0) : vec2(slant.x, face == 3 ? -slant.y : slant.y);
    float eta = glass ? glassIndex : 1.0 / glassIndex;
    float cosine = dot(normal, d.yz);
    float square = 1.0 - eta * eta * (1.0 - cosine * cosine);
    bool total = square < 0.0;
    float change = total ? -2.0 * cosine : sign(cosine) * sqrt(max(square, 0.0)) - eta * cosine;
    float scale = total ? 1.0 : eta;
    d = vec3(scale * d.x, scale * d.yz + change * normal);
    if (!total) {
      if (face == 1) {  // through the gap between two prisms
        cell += glass ? -1.0 : 1.0;
        p.y = glass ? 1.0 : 0.0;
      }
      glass = !glass;
    }
    ray.faces++;
    if (ray.faces <= 9) {
      ray.path += digit * float(face);
      digit *= 5.0;
    }
    if (ray.faces == maxFaces) break;
  }
  ray.position = p * pitch;
  ray.direction = normalize(d);
  return ray;
}
