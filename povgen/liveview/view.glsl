// What the eye sees in a pixel: one ray from the eye through the windows to what it ends on, and its colour.

uniform vec3 eye;
uniform vec3 viewMiddle, viewRight, viewUp;  // of the rectangle that the picture shows: its middle, and along its sides
uniform float viewHeight;    // height of this rectangle, tiles
uniform vec2 size;           // of the picture, pixels
uniform vec2 jitter;         // the ray's place in its pixel, from the centre, pixels

struct Seen {
  vec3 origin, direction;  // of the ray that leaves the last window; if it meets none, of the eye's ray
  vec3 eyeDirection;       // of the eye's ray
  Hit hit;                 // what this ray meets first
  bool lost;               // the ray has met too many faces or windows, or a sheet that lets no light pass
  Passage passage;         // through the last window of prisms
};

// Where a pixel's ray crosses the plane of the picture.
vec3 placeOf(vec2 pixel) {
  vec2 at = (pixel + jitter - size / 2.0) / size.y * viewHeight;
  return viewMiddle + at.x * viewRight + at.y * viewUp;
}

// The window that a ray meets first, -1: none, and how far away. o is a point of the ray, which starts at t = `start`.
int windowMet(vec3 o, vec3 d, float start, int last, out float reach) {
  int met = -1;
  reach = 1e30;
  for (int w = 0; w < WINDOWS; w++) {
    if (w == last || kind[w] == -2) continue;  // an empty window leaves light as it is
    vec3 p = toWindow(w, o - windowPlace[w]), v = toWindow(w, d);
    float half_ = sheetCounts[w] > 0 ? prismHalves[w] * pitches[w] - sheetCentres[2 * w] : 0.0;  // of the sheets' extent along z
    float t = (-sign(v.z) * half_ - p.z) / v.z;
    if (t > start && t < reach && isInWindow(w, p.xy + t * v.xy)) {
      met = w;
      reach = t;
    }
  }
  return met;
}

const int MOST_WINDOWS = 100;  // that a ray passes; the trace in numpy has the same limit

// What the eye sees at a place in the plane of the picture. A ray to the first window is counted from there, not from the
// eye: a far eye's distance, in pitches, would have too many digits.
Seen see(vec3 place) {
  Seen seen;
  vec3 d = normalize(place - eye), o = place;  // a point of the ray
  float start = -distance(place, eye);         // where the ray starts, from there
  seen.origin = eye;
  seen.direction = seen.eyeDirection = d;
  seen.lost = false;
  seen.passage = Passage(eye, d, THROUGH, 0);
  int last = -1;
  for (int k = 0; k < MOST_WINDOWS; k++) {
    float reach;
    int met = windowMet(o, d, start, last, reach);
    seen.hit = meet(seen.origin, d, met < 0 ? 1e30 : reach - start);
    if (seen.hit.what != SKY || met < 0) return seen;
    vec3 p = toWindow(met, o - windowPlace[met]), v = toWindow(met, d);
    if (sheetCounts[met] > 0) {
      seen.passage = passage(Passage(p, v, THROUGH, seen.passage.faces), met);
      p = seen.passage.position;
      v = seen.passage.direction;
      seen.lost = seen.passage.end == UNFINISHED || seen.passage.end == BLACKENED;
    } else {
      p += reach * v;
      p.z = 0.0;
      bool forward = v.z > 0.0;
      v = forward ? bent(v, p.xy, met) : bentFromBehind(v, p.xy, met);
      seen.lost = v.z > 0.0 != forward;
    }
    seen.origin = o = fromWindow(met, p) + windowPlace[met];
    seen.direction = d = fromWindow(met, v);
    if (seen.lost) return seen;
    if (sheetCounts[met] > 0 && seen.passage.end == FRAME) {
      vec2 far = p.xy / windowHalf[met];
      vec2 inwards = windowRound[met] ? -normalize(far / windowHalf[met])
        : abs(far.x) > abs(far.y) ? vec2(-sign(far.x), 0) : vec2(0, -sign(far.y));
      seen.hit = Hit(0.0, WINDOW_FRAME + met, fromWindow(met, vec3(inwards, 0)));
      return seen;
    }
    start = 0.0;
    last = met;
  }
  seen.lost = true;
  return seen;
}

Finish finishOf(int what, vec3 p) {
  if (what == FLOOR) return FloorTexture(p);
#if OBJECTS > 0
  if (what >= OBJECT) return materialOf(what - OBJECT, p);
#endif
  int w = what - WINDOW_FRAME;
  return FrameTexture(w, toWindow(w, p - windowPlace[w]));
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
