// What the eye sees in a pixel: one ray from the eye through the sheets to what stands behind them, and its colour.

uniform int simulated;       // how many windows are ideal sheets: the first ones
uniform vec3 eye;
uniform float viewHeight;    // height of the picture in the plane z = 0, tiles
uniform vec2 size;           // of the picture, pixels
uniform vec2 jitter;         // the ray's place in its pixel, from the centre, pixels

struct Seen {
  vec3 origin, direction;  // of the ray that leaves the sheets; without sheets, of the eye's ray
  vec3 eyeDirection;       // of the eye's ray
  Hit hit;                 // what this ray meets first
  bool lost;               // the ray has met too many faces
  Passage passage;         // through the prisms
};

// Where a pixel's ray crosses the plane z = 0.
vec3 placeOf(vec2 pixel) {
  return vec3((pixel + jitter - size / 2.0) / size.y * viewHeight, 0);
}

bool isInWindow(vec2 place) {
  return max(abs(place.x), abs(place.y)) < window / 2.0;
}

// Whether a ray that crosses the middle plane of a window there passes the frame's front opening, and then the opening at z,
// within the frame.
bool entersWindow(vec2 place, vec3 d, float z) {
  vec2 slope = d.xy / d.z;
  return isInWindow(place - slope * frameDepth / 2.0) && isInWindow(place + slope * z);
}

// Take an eye's ray, which crosses the first window at `seen.origin`, through all ideal sheets that it meets.
void passIdealSheets(inout Seen seen) {
  seen.direction = bent(seen.direction, seen.origin.xy, 0);
  seen.lost = seen.direction.z < 0.0;
  for (int w = 1; w < simulated && !seen.lost; w++) {
    vec3 d = seen.direction;
    vec2 place = seen.origin.xy + d.xy / d.z * (windowZ[w] - windowZ[w - 1]);
    if (!isInWindow(seen.origin.xy + d.xy / d.z * frameDepth / 2.0) || !entersWindow(place, d, 0.0)) return;
    seen.origin = vec3(place, windowZ[w]);
    seen.direction = bent(d, seen.origin.xy, w);
    seen.lost = seen.direction.z < 0.0;
  }
}

// The window of prisms that a ray meets before anything else; -1: none.
int windowMet(vec3 o, vec3 d, float before) {
  int met = -1;
  for (int w = simulated; w < WINDOWS; w++) {
    if (sheetCounts[w] == 0) continue;  // it leaves light as it is
    float half_ = prismHalves[w] * pitches[w] - sheetCentres[2 * w];  // of the sheets' extent along z
    float t = (windowZ[w] - sign(d.z) * half_ - o.z) / d.z;
    if (t > 0.0 && t < before && isInWindow(o.xy + t * d.xy)) {
      met = w;
      before = t;
    }
  }
  return met;
}

const int MOST_PASSAGES = 20;  // through windows of prisms; almost every ray has met maxFaces faces before

// What the eye sees at a place in the plane z = 0. Rays to the first window start there, not at the eye: a far eye's distance,
// in pitches, would have too many digits.
Seen see(vec3 place) {
  Seen seen;
  vec3 d = normalize(place - eye);
  float front = simulated > 0 ? 0.0 : sheetCentres[0] - prismHalves[0] * pitches[0];
  bool enters = sheetCounts[WINDOWS - 1] + simulated > 0 && entersWindow(place.xy, d, front);
  seen.origin = enters ? place : eye;
  seen.direction = seen.eyeDirection = d;
  seen.lost = false;
  seen.passage = Passage(eye, d, THROUGH, 0);
  int met = enters && simulated == 0 ? 0 : -1;
  if (enters && simulated > 0) passIdealSheets(seen);
  seen.hit = Hit(0.0, SKY, vec3(0));
#if WINDOWS > 1
  for (int k = 0; k < MOST_PASSAGES; k++)  // light can be reflected between windows
#endif
  {
    if (met >= 0) {
      seen.passage.position = seen.origin;
      seen.passage.direction = seen.direction;
      seen.passage = passage(seen.passage, met);
      seen.origin = seen.passage.position;
      seen.direction = seen.passage.direction;
      seen.lost = seen.passage.end == UNFINISHED || seen.passage.end == BLACKENED;
    }
    if (seen.passage.end == FRAME) {
      vec2 inwards = abs(seen.origin.x) > abs(seen.origin.y) ? vec2(-sign(seen.origin.x), 0) : vec2(0, -sign(seen.origin.y));
      seen.hit = Hit(0.0, WINDOW_FRAME, vec3(inwards, 0));
    } else if (!seen.lost) {
      seen.hit = meet(seen.origin, seen.direction);
    }
#if WINDOWS > 1
    met = seen.lost || seen.passage.end == FRAME || sheetCounts[WINDOWS - 1] == 0 ? -1 : windowMet(seen.origin, seen.direction, seen.hit.t);
    if (met < 0) break;
#endif
  }
  return seen;
}

// POV-Ray's shading: ambient, diffuse and specular light, without reflections. The fourth number is 0 where nothing is,
// otherwise 1.
vec4 colourOf(Seen seen) {
  if (seen.lost) return vec4(0, 0, 0, 1);
  if (seen.hit.what == SKY) return background == TRANSPARENT ? vec4(0) : vec4(skyColour(seen.direction), 1);
  vec3 p = seen.origin + seen.hit.t * seen.direction, normal = seen.hit.normal;
  Finish finish = finishOf(seen.hit.what, p);
  vec3 sun = normalize(sunDirection);
  float facing = dot(normal, sun);
  vec3 light = vec3(finish.ambient) + fillColour * finish.diffuse * max(dot(normal, normalize(fillDirection)), 0.0);
  vec3 highlight = vec3(0);
  if (facing > 0.0 && !shadowed(p + 0.004 * normal, shadowDirection())) {
    light += sunColour * finish.diffuse * facing;
    // In POV-Ray a light without shadows, such as the fill light, makes no highlights.
    float mirrored = max(dot(normal, normalize(sun - seen.direction)), 0.0);
    highlight = sunColour * finish.specular * pow(mirrored, 1.0 / finish.roughness);
    if (finish.metallic) {  // the highlight has the metal's colour, except at grazing light
      float grazing = acos(facing) * 2.0 / PI - 1.12;
      highlight *= mix(finish.pigment, vec3(1), clamp(0.014567225 / (grazing * grazing) - 0.011612903, 0.0, 1.0));
    }
  }
  light = finish.pigment * light + highlight;
#ifndef UNCLIPPED  // for a picture of bytes, whose pixels are not brighter than white
  light = min(light, 1.0);
#endif
  return vec4(light, 1);
}
