// The ray trace through sheets of Dove prisms, and of other profiles, as in povgen/optics/trace.py.
//
// A ray is kept in the coordinates of the prism that it is at: the number `cell` of the prism, and the height u above
// its base, in units of the pitch. So 32-bit numbers are precise enough for any number of prisms. The cells of another profile
// are its periods. The code for Dove prisms is special, because a frame then takes half the time. Lenses turn an error of a
// ray's place into one of its direction: docs/accuracy.md says how large it is.

const int THROUGH = 0;     // leaves the sheets away from the eye
const int BACK = 1;        // leaves them towards the eye
const int FRAME = 2;       // meets the window frame
const int UNFINISHED = 3;  // has met the greatest allowed number of faces
const int ABSORBED = 6;    // has met a black top

struct Passage {
  vec3 position;   // where the ray leaves the sheets, or meets the window's edge, in the window's coordinates, tiles
  vec3 direction;  // unit vector
  int end;
  int faces;       // how many faces it has met
};

#ifdef PRISMS
// for each window
uniform int sheetCounts[WINDOWS];        // how many sheets of prisms: 1 or 2; 0: none
uniform vec2 sheetTurns[2 * WINDOWS];    // cosine and sine of each sheet's angle
uniform vec3 sheetAxes[6 * WINDOWS];     // three for each sheet: its axes, if it is tilted but not turned
uniform float sheetCentres[2 * WINDOWS]; // z of the sheets' middle planes, from the middle of their window, tiles
uniform float pitches[WINDOWS];          // from one prism to the next, tiles
uniform float firstBases[WINDOWS];       // y of the base of prism 0, in pitches
uniform float prismHeights[WINDOWS];     // from base to top, in pitches
uniform float prismHalves[WINDOWS];      // half of the length along z, in pitches
uniform vec2 slants[2 * WINDOWS];        // cosine and sine of the base angle, for each sheet
uniform float glassIndices[2 * WINDOWS]; // for each sheet
uniform bool blackTops[WINDOWS];

#ifdef PROFILE_EDGES
uniform int profileCounts[WINDOWS];                  // edges of the profile of a window's sheets; 0: Dove prisms
uniform vec4 profileEdges[WINDOWS * PROFILE_EDGES];  // start and end of each edge: u and z, in pitches
uniform float profileRadii[WINDOWS * PROFILE_EDGES]; // above 0: an arc where the glass bulges; 0: a straight edge
const int BORDER = -1;                               // in place of a face: the border between two cells

// Where a ray in a cell first meets an edge or a border, which one, and the normal out of the glass. An edge counts
// only if the ray crosses it in the right direction: into the glass from air, out of it from glass. So the ray does not meet
// the same edge twice.
void meetEdge(int number, bool glass, vec2 o, vec2 d, inout float t, inout int face, inout vec2 normal) {
  const float LEAST = 1e-6;
  float outwards = glass ? 1.0 : -1.0;
  t = ((d.x > 0.0 ? 1.0 : 0.0) - o.x) / d.x;
  face = BORDER;
  for (int e = 0; e < profileCounts[number]; e++) {
    vec4 ends = profileEdges[number * PROFILE_EDGES + e];
    float radius = profileRadii[number * PROFILE_EDGES + e], chord = distance(ends.xy, ends.zw);
    vec2 along = (ends.zw - ends.xy) / chord, across = vec2(along.y, -along.x), n = across;
    float reach;
    bool meets;
    if (radius == 0.0) {
      float speed = dot(across, d);
      reach = dot(across, ends.xy - o) / speed;
      meets = speed * outwards > 0.0;
    } else {
      float depth = sqrt(max(radius * radius - chord * chord / 4.0, 0.0)) * sign(radius);
      vec2 q = o - (ends.xy + ends.zw) / 2.0 + depth * across;
      float a = dot(d, d), b = dot(q, d), root = b * b - a * (dot(q, q) - radius * radius);
      reach = (outwards * sign(radius) * sqrt(max(root, 0.0)) - b) / a;
      meets = root > 0.0;
      n = (q + reach * d) / radius;
    }
    vec2 at = o + reach * d - ends.xy;
    float place = dot(along, at);
    meets = meets && reach > -LEAST && reach < t && place > -LEAST && place < chord + LEAST;
    if (meets && sign(radius) * dot(across, at) > -LEAST) {
      t = reach;
      face = e + 1;
      normal = n;
    }
  }
  t = max(t, 0.0);
}
#endif

uniform int maxFaces;           // as POV-Ray's max_trace_level: a ray that meets as many is dark

#ifdef PATH  // for rays.glsl, which asks for the designed path
uniform int designedPath[PATH];  // the faces, or the edges of a profile, that a ray to greater z meets
int pathPlace, pathStep;         // of the next face on the designed path, and of the one after
bool onPath = true;
vec2 orders = vec2(0);           // for each sheet: the cell of the last lens, minus that of the first
#endif

mat3 axesOf(int sheet) { return mat3(sheetAxes[3 * sheet], sheetAxes[3 * sheet + 1], sheetAxes[3 * sheet + 2]); }

// Follow a ray through the sheets of a window. It comes from outside. `ray.position` is any point of its line. Position and
// direction are in the window's coordinates.
Passage passage(Passage ray, int number) {
  const float FAR = 1e30;
  int sheets = sheetCounts[number];
  float pitch = pitches[number], firstBase = firstBases[number], prismHeight = prismHeights[number];
  float prismHalf = prismHalves[number], glassIndex = 1.0;
  vec2 slant = vec2(1, 0);
  vec3 p = ray.position / pitch;  // the window's axes while the ray is between sheets; in a sheet its own, with u for y
  vec3 d = ray.direction;
  int at = d.z > 0.0 ? 0 : sheets - 1;
  float cell = 0.0;
  vec2 turn = vec2(1, 0);
  mat3 axes = mat3(1);
  bool between = true, glass = false, dove = true;
  vec2 normal = vec2(0);
#ifdef PATH
  float firstCell = FAR, lastCell = FAR;  // in which the ray has met glass in its sheet
#endif
#ifdef PROFILE_EDGES
  dove = profileCounts[number] == 0;
#endif
  ray.end = UNFINISHED;

  // maxFaces ends the loop earlier. A step to the border of a cell counts for no face: rays through 1000 lenses took up to
  // 733 steps.
  for (int step = 0; step < 1000; step++) {
    if (between) {
      if (at < 0 || at >= sheets) {
        ray.end = d.z > 0.0 ? THROUGH : BACK;
        break;
      }
      float surface = d.z > 0.0 ? -prismHalf : prismHalf;
      p.z -= sheetCentres[2 * number + at] / pitch;
      axes = axesOf(2 * number + at);
      p = p * axes;
      d = d * axes;
      p += d * ((surface - p.z) / d.z);
      if (!isInWindow(number, pitch * (axes * p).xy)) {
        ray.end = FRAME;
        p = axes * p;
        d = axes * d;
#ifndef PATH
        p -= d * beyondWindow(number, pitch * p.xy, d.xy) / pitch;
#endif
        p.z += sheetCentres[2 * number + at] / pitch;
        break;
      }
      turn = sheetTurns[2 * number + at];
      slant = slants[2 * number + at];
      glassIndex = glassIndices[2 * number + at];
      float v = turn.x * p.y - turn.y * p.x - firstBase;
      cell = floor(v);
      p = vec3(turn.x * p.x + turn.y * p.y, v - cell, surface);
      d.xy = vec2(turn.x * d.x + turn.y * d.y, turn.x * d.y - turn.y * d.x);
      between = false;
    }
    if (abs(d.y) < 1e-12) d.y = 1e-12;

    float t;
    int face;
    float side = max(((d.z > 0.0 ? prismHalf : -prismHalf) - p.z) / d.z, 0.0);
#ifdef PROFILE_EDGES
    if (!dove) {
      meetEdge(number, glass, p.yz, d.yz, t, face, normal);
      if (!glass && (side < t || side == t && face == BORDER)) { t = side; face = 0; }
    } else
#endif
    {
      // The four planes of a prism: how fast the ray approaches the slanted ones from inside, and when it meets each.
      bool up = d.y > 0.0;
      float level = ((up ? prismHeight : 0.0) - p.y) / d.y;
      vec2 along = vec2(slant.x * d.y - slant.y * d.z, slant.x * d.y + slant.y * d.z);
      vec2 reach = (slant.y * prismHalf - vec2(slant.x * p.y - slant.y * p.z, slant.x * p.y + slant.y * p.z)) / along;
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
        if (side <= t) { t = side; face = 0; }  // leaves the sheet
      }
      normal = face == 1 ? vec2(-1, 0) : face == 2 ? vec2(1, 0) : vec2(slant.x, face == 3 ? -slant.y : slant.y);
    }

    // Move on. Inside the window frame the ray ends, where it met the frame's inner faces.
    p += t * d;
    float y = p.y + cell + firstBase;
    vec3 place = axes * vec3(turn.x * p.x - turn.y * y, turn.y * p.x + turn.x * y, p.z);
    bool outside = !isInWindow(number, pitch * place.xy);
    if (face == 0 || outside) {
      d = axes * vec3(turn.x * d.x - turn.y * d.y, turn.y * d.x + turn.x * d.y, d.z);
      p = place;
      if (outside) {
#ifndef PATH
        p -= d * min(beyondWindow(number, pitch * p.xy, d.xy) / pitch, t);
#endif
        ray.end = FRAME;
      }
      p.z += sheetCentres[2 * number + at] / pitch;
      if (ray.end == FRAME) break;
      between = true;
#ifdef PATH
      if (!dove) orders[at] += lastCell - firstCell;
      firstCell = lastCell = FAR;
#endif
      at += d.z > 0.0 ? 1 : -1;
      continue;
    }

#ifdef PROFILE_EDGES
    if (face == BORDER) {
      cell += d.y > 0.0 ? 1.0 : -1.0;
      p.y = d.y > 0.0 ? 0.0 : 1.0;
      continue;
    }
#endif
    ray.faces++;
#ifdef PATH
    onPath = onPath && pathPlace >= 0 && pathPlace < PATH && face == designedPath[pathPlace];
    pathPlace += pathStep;
    lastCell = cell;
    if (firstCell == FAR) firstCell = cell;
#endif
    if (face == 2 && blackTops[number]) {
      ray.end = ABSORBED;
      break;
    }

    // Refract the ray, or reflect it totally. `cosine` is positive for a ray that leaves the prism. A refracted direction is
    // composed of its parts along the face and across it. So errors of its length do not grow from face to face.
    vec2 tangent = vec2(-normal.y, normal.x);
    float cosine = dot(normal, d.yz), sine = dot(tangent, d.yz);
    float eta = glass ? glassIndex : 1.0 / glassIndex;
    float square = 1.0 - eta * eta * (d.x * d.x + sine * sine);
    bool total = square < 0.0;
    if (total) d.yz -= 2.0 * cosine * normal;
    else d = vec3(eta * d.x, eta * sine * tangent + sign(cosine) * sqrt(square) * normal);
    if (!total) {
      if (dove && face == 1) {  // through the gap between two prisms
        cell += glass ? -1.0 : 1.0;
        p.y = glass ? 1.0 : 0.0;
      }
      glass = !glass;
    }
    if (ray.faces >= maxFaces) break;
  }
#ifdef PATH
  if ((ray.end == UNFINISHED && !between) || ray.end == ABSORBED) {  // it ends in a sheet
    p.y += cell + firstBase;
    p = axes * vec3(turn.x * p.x - turn.y * p.y, turn.y * p.x + turn.x * p.y, p.z);
    p.z += sheetCentres[2 * number + at] / pitch;
    d = axes * vec3(turn.x * d.x - turn.y * d.y, turn.y * d.x + turn.x * d.y, d.z);
  }
#endif
  ray.position = p * pitch;
  ray.direction = normalize(d);
  return ray;
}
#endif
