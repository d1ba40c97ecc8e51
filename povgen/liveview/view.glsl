// What the eye sees in a pixel: one ray from the eye through the windows to what it ends on, and its colour.

uniform vec3 eye;
uniform vec3 viewMiddle, viewRight, viewUp;  // of the rectangle that the picture shows: its middle, and along its sides
uniform float viewHeight;    // height of this rectangle, tiles
uniform vec2 size;           // of the picture, pixels
uniform vec2 jitter;         // the ray's place in its pixel, from the centre, pixels
#ifdef PUPIL
uniform float pupil;         // its radius, tiles
uniform float outOfFocus;    // how far the picture moves with the eye, of the eye's way: 0 if the eye is focused on its plane
#endif

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

#ifdef PUPIL
// How far from the middle of the pupil a ray enters it: povgen/scene/pupil.py.
vec3 asideInPupil() {
  vec2 u = fract(float(rayNumber) * vec2(0.8566748838545029, 0.733891856627126));
  return pupil * sqrt(u.x) * (cos(2.0 * PI * u.y) * viewRight + sin(2.0 * PI * u.y) * viewUp);
}
#endif

// Where a ray crosses the end of a window's frame: the far one if side = 1, the near one if side = -1.
vec2 openingAt(int w, float side, vec3 o, vec3 d) {
  vec3 p = toWindow(w, o - windowPlace[w]), v = toWindow(w, d);
  return p.xy + (side * windowDepth[w] / 2.0 - p.z) / v.z * v.xy;
}

// The window that a ray meets first, -1: none, and how far away. o is a point of the ray, which starts at t = `start`.
// `last` is the window that it leaves, -1: none.
int windowMet(vec3 o, vec3 d, float start, int last, out float reach) {
  int met = -1;
  reach = 1e30;
#if defined(AXIAL) && WINDOWS > 1
  if (last >= 0 && !isInWindow(last, openingAt(last, sign(d.z), o, d))) return -1;  // it meets the frame from inside
#endif
  EACH_WINDOW(w) {
    vec3 p = toWindow(w, o - windowPlace[w]), v = toWindow(w, d);
#ifdef PRISMS
    float half_ = sheetCounts[w] > 0 ? prismHalves[w] * pitches[w] - sheetCentres[2 * w] : 0.0;  // of the sheets' extent along z
#else
    float half_ = 0.0;
#endif
    float t = (-sign(v.z) * half_ - p.z) / v.z;
    bool enters = w != last && kind[w] != -2 && isInWindow(w, p.xy + t * v.xy);  // an empty window leaves light as it is
#ifdef AXIAL
    enters = enters && isInWindow(w, openingAt(w, -sign(d.z), o, d));
#endif
    if (enters && t > start && t < reach) {
      met = w;
      reach = t;
    }
  }
  return met;
}

// Take a ray through a window. o is a point of the ray, and the window is met at t = `reach`. Return whether the ray ends there.
bool endsIn(int w, inout Seen seen, inout vec3 o, float reach) {
  vec3 p = toWindow(w, o - windowPlace[w]), d = toWindow(w, seen.direction);
#ifdef PRISMS
  if (sheetCounts[w] > 0) {
    seen.passage = passage(Passage(p, d, THROUGH, seen.passage.faces), w);
    p = seen.passage.position;
    d = seen.passage.direction;
    seen.lost = seen.passage.end == UNFINISHED || seen.passage.end == ABSORBED;
    if (seen.passage.end == FRAME) {
      vec2 far = p.xy / windowHalf[w];
      vec2 inwards = abs(far.x) > abs(far.y) ? vec2(-sign(far.x), 0) : vec2(0, -sign(far.y));
#ifdef ROUND_WINDOWS
      if (windowRound[w]) inwards = -normalize(far / windowHalf[w]);
#endif
      seen.hit = Hit(0.0, WINDOW_FRAME + w, fromWindow(w, vec3(inwards, 0)));
    }
  }
#endif
#ifdef LAWS
  if (kind[w] >= 0) {
    p = vec3(p.xy + reach * d.xy, 0);
    float forward = d.z;
#ifdef FROM_BEHIND
    d = forward > 0.0 ? bent(d, p.xy, w) : bentFromBehind(d, p.xy, w);
#else
    d = bent(d, p.xy, w);
#endif
    seen.lost = d.z * forward <= 0.0;
  }
#endif
  seen.origin = o = fromWindow(w, p) + windowPlace[w];
  seen.direction = fromWindow(w, d);
  return seen.lost || seen.hit.what != SKY;
}

const int MOST_WINDOWS = 100;  // that a ray passes; the trace in numpy has the same limit

// What the eye sees at a place in the plane of the picture. A ray to the first window is counted from there, not from the
// eye: a far eye's distance, in pitches, would have too many digits.
Seen see(vec3 place) {
  vec3 from = eye;
#ifdef PUPIL
  from += asideInPupil();
  place += outOfFocus * asideInPupil();
#endif
  vec3 o = place, d = normalize(place - from);  // a point of the ray, and its direction
  float start = -distance(place, from), reach;  // where the ray starts, from this point
  Seen seen = Seen(from, d, d, Hit(0.0, SKY, vec3(0)), false, Passage(from, d, THROUGH, 0));
#if defined(AXIAL) && WINDOWS == 1  // a ray into its frame meets nothing else before the sheets
  if (windowMet(o, d, start, -1, reach) == 0 && endsIn(0, seen, o, reach)) return seen;
#else
  int last = -1, met = windowMet(o, d, start, last, reach);
  for (int k = 0; k < MOST_WINDOWS && met >= 0; k++) {
#ifdef AXIAL
    if (abs(met - last) > 1) {  // otherwise nothing stands between these windows' openings
      seen.hit.t = reach - start;
      meetFrames(seen.origin, seen.direction, seen.hit);
    }
#else
    seen.hit = meet(seen.origin, seen.direction, reach - start);
#endif
    if (seen.hit.what != SKY || endsIn(met, seen, o, reach)) return seen;
    start = 0.0;
    last = met;
    met = windowMet(o, seen.direction, start, last, reach);
  }
  seen.lost = met >= 0;
#endif
  seen.hit = meet(seen.origin, seen.direction, 1e30);
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
  vec3 around = skyLight * max(dot(normal, normalize(skyDirection)), 0.0) + groundLight * max(dot(normal, normalize(groundDirection)), 0.0);
  vec3 light = vec3(finish.ambient) + finish.diffuse * around;
  vec3 highlight = vec3(0);
  if (facing > 0.0 && !shadowed(p + 0.004 * normal, shadowDirection())) {
    light += sunColour * finish.diffuse * facing;
    // In POV-Ray a light without shadows, such as the sky's, makes no highlights.
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
