// The ray trace through sheets of Dove prisms, as in povgen/optics/trace.py.
//
// A ray is kept in the coordinates of the prism that it is at: the number `cell` of the prism, and the height u above
// its base, in units of the pitch. So 32-bit numbers are precise enough for any number of prisms.

const int THROUGH = 0;     // leaves the sheets away from the eye
const int BACK = 1;        // leaves them towards the eye
const int FRAME = 2;       // meets the window frame
const int UNFINISHED = 3;  // has met the greatest allowed number of faces

const int BLACKENED = 4;   // has met a blackened top

uniform int sheets;             // how many sheets of prisms a window has: 1 or 2; 0: none
uniform vec2 sheetTurn[2 * WINDOWS];  // cosine and sine of each sheet's angle
uniform float sheetCentre[2];   // z of the sheets' middle planes, from the middle of their window, tiles
uniform float pitch;            // from one prism to the next, tiles
uniform float firstBase;        // y of the base of prism 0, in pitches
uniform float prismHeight;      // from base to top, in pitches
uniform float prismHalf;        // half of the length along z, in pitches
uniform vec2 slant;             // cosine and sine of the base angle
uniform float glassIndex;
uniform bool blackTops;
uniform int maxFaces;           // as POV-Ray's max_trace_level: a ray that meets as many is dark

struct Passage {
  vec3 position;   // where the ray leaves the sheets, or meets the window frame, tiles
  vec3 direction;  // unit vector
  int end;
  int faces;       // how many faces it has met
};

// Follow a ray through the sheets of a window. It comes from outside. `ray.position` is any point of its line.
Passage passage(Passage ray, int number) {
  const float FAR = 1e30;
  float halfWindow = window / 2.0 / pitch;
  vec3 middle = vec3(0, 0, windowZ[number]);
  vec3 p = (ray.position - middle) / pitch;  // the window's axes while the ray is between sheets; in a sheet its own, with u for y
  vec3 d = ray.direction;
  int at = d.z > 0.0 ? 0 : sheets - 1;
  float cell = 0.0;
  vec2 turn = vec2(1, 0);
  bool between = true, glass = false;
  ray.end = UNFINISHED;

  for (int step = 0; step < 400; step++) {  // maxFaces ends it earlier
    if (between) {
      if (at < 0 || at >= sheets) {
        ray.end = d.z > 0.0 ? THROUGH : BACK;
        break;
      }
      float surface = d.z > 0.0 ? -prismHalf : prismHalf;
      p += d * ((surface + sheetCentre[at] / pitch - p.z) / d.z);
      if (max(abs(p.x), abs(p.y)) > halfWindow) {
        ray.end = FRAME;
        break;
      }
      turn = sheetTurn[2 * number + at];
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

    ray.faces++;
    if (face == 2 && blackTops) {
      ray.end = BLACKENED;
      break;
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
    if (ray.faces >= maxFaces) break;
  }
  ray.position = p * pitch + middle;
  ray.direction = normalize(d);
  return ray;
}
