// The windows' openings and frames, and where a ray meets a frame. Lengths are in tiles.

const int SKY = 0;
const int FLOOR = 1;
const int WINDOW_FRAME = 2;  // of the first window; the next is 3, and so on
const int OBJECT = WINDOW_FRAME + WINDOWS;  // the first object; the next is one more, and so on

uniform vec3 windowPlace[WINDOWS];     // the middle of each window
uniform vec2 windowHalf[WINDOWS];      // half its width and height
uniform float windowDepth[WINDOWS];    // extent of its frame along its z; 0: it has none
uniform bool windowFramed[WINDOWS];    // whether the frame is seen; otherwise it is a black edge without width
uniform float frameRim;                // width of a frame's sides
uniform bool hasFloor;
uniform float floorY;
uniform float horizon;                 // how far away the floor ends
#ifdef ROUND_WINDOWS
uniform bool windowRound[WINDOWS];     // whether the opening is an ellipse
#endif
#ifdef TURNED_WINDOWS
uniform mat3 windowAxes[WINDOWS];      // the axes of each window: its columns
#endif

// What a scene does not need takes time even where a branch leaves it out: with PRISMS there are sheets of prisms or lenses, with
// LAWS ideal ones, and with AXIAL the windows stand one behind the other, with the eye in front and all objects behind them.
#if defined(LAWS) && (!defined(AXIAL) || WINDOWS > 1 && defined(PRISMS))
#define FROM_BEHIND  // light can meet an ideal sheet from behind
#endif
#if WINDOWS > 1
#define EACH_WINDOW(w) for (int w = 0; w < WINDOWS; w++)
#else
#define EACH_WINDOW(w) const int w = 0;
#endif

struct Hit {
  float t;      // how far along the ray; the direction is a unit vector
  int what;     // SKY, FLOOR, WINDOW_FRAME + the number of the window, or OBJECT + the number of the object
  vec3 normal;  // unit vector, towards the ray's start
};

struct Finish {
  vec3 pigment;
  float ambient, diffuse, specular, roughness;
  bool metallic;
};

// A direction of the scene in the coordinates of a window, and back.
vec3 toWindow(int w, vec3 v) {
#ifdef TURNED_WINDOWS
  return v * windowAxes[w];
#else
  return v;
#endif
}
vec3 fromWindow(int w, vec3 v) {
#ifdef TURNED_WINDOWS
  return windowAxes[w] * v;
#else
  return v;
#endif
}

// When a ray enters and leaves a box.
vec2 boxed(vec3 o, vec3 d, vec3 lower, vec3 upper) {
  vec3 a = (lower - o) / d, b = (upper - o) / d;
  vec3 least = min(a, b), most = max(a, b);
  return vec2(max(max(least.x, least.y), least.z), min(min(most.x, most.y), most.z));
}

// How far along a ray that starts outside a box meets it, or `most`.
float reachOfBox(vec3 o, vec3 d, vec3 lower, vec3 upper, float most) {
  vec2 reach = boxed(o, d, lower, upper);
  return reach.x < reach.y && reach.x > 0.0 && reach.x < most ? reach.x : most;
}

// The normal of a cube from -1 to 1 at a point of its surface.
vec3 faceNormal(vec3 p) {
  vec3 far = abs(p);
  return sign(p) * (far.x > max(far.y, far.z) ? vec3(1, 0, 0) : far.y > far.z ? vec3(0, 1, 0) : vec3(0, 0, 1));
}

// ---- Windows ----

bool isInWindow(int w, vec2 place) {
#ifdef ROUND_WINDOWS
  vec2 far = place / windowHalf[w];
  if (windowRound[w]) return dot(far, far) < 1.0;
#endif
  return all(lessThan(abs(place), windowHalf[w]));
}

// How far a ray has gone, since it left the space within a window's outline, to a place outside.
float beyondWindow(int w, vec2 place, vec2 d) {
#ifdef ROUND_WINDOWS
  if (windowRound[w]) {
    vec2 p = place / windowHalf[w], v = d / windowHalf[w];
    float a = max(dot(v, v), 1e-18), b = dot(p, v);
    return max((b - sqrt(max(b * b - a * (dot(p, p) - 1.0), 0.0))) / a, 0.0);
  }
#endif
  vec2 back = max((abs(place) - windowHalf[w]) / max(abs(d), 1e-9), 0.0);
  return max(back.x, back.y);
}

// A face of a frame's four sides. In the cross-section it runs from a to b: distance from the opening, and z.
void meetFrameFace(int w, vec3 o, vec3 d, vec2 a, vec2 b, inout Hit hit) {
  vec2 across = normalize(vec2(b.y - a.y, a.x - b.x));
  for (int side = 0; side < 4; side++) {
    vec2 away = side == 0 ? vec2(1, 0) : side == 1 ? vec2(0, 1) : side == 2 ? vec2(-1, 0) : vec2(0, -1);  // to this side
    vec2 start = vec2(dot(away, o.xy) - dot(abs(away), windowHalf[w]), o.z), step = vec2(dot(away, d.xy), d.z);
    float t = dot(across, a - start) / dot(across, step);
    if (t > 0.0 && t < hit.t) {
      vec2 place = start + t * step, low = min(a, b), high = max(a, b);
      bool within = high.x - low.x > high.y - low.y
        ? place.x >= low.x && place.x <= high.x
        : place.y >= low.y && place.y <= high.y;
      float aside = abs(dot(away.yx, o.xy + t * d.xy)) - dot(abs(away.yx), windowHalf[w]);  // the sides' ends are mitred
      if (within && aside <= place.x) {
        vec3 normal = vec3(across.x * away, across.y);
        hit = Hit(t, WINDOW_FRAME + w, dot(normal, d) > 0.0 ? -normal : normal);
      }
    }
  }
}

#ifdef ROUND_WINDOWS
// The round frame: a ring between two cylinders and two planes. o and d are in the window's coordinates.
void meetRing(int w, vec3 o, vec3 d, inout Hit hit) {
  float back = windowDepth[w] / 2.0;
  vec2 inner = windowHalf[w], outer = inner + (windowFramed[w] ? frameRim : 0.0);
  for (int side = 0; side < 2; side++) {
    vec2 half_ = side == 0 ? inner : outer;
    vec2 p = o.xy / half_, v = d.xy / half_;
    float a = dot(v, v), b = dot(p, v), root = b * b - a * (dot(p, p) - 1.0);
    for (int end = 0; end < 2 && root > 0.0; end++) {
      float t = ((end == 0 ? -1.0 : 1.0) * sqrt(root) - b) / a;
      if (t > 0.0 && t < hit.t && abs(o.z + t * d.z) <= back) {
        vec3 normal = vec3(normalize((o.xy + t * d.xy) / (half_ * half_)), 0);
        hit = Hit(t, WINDOW_FRAME + w, dot(normal, d) > 0.0 ? -normal : normal);
      }
    }
  }
  for (int end = 0; end < 2; end++) {
    float t = ((end == 0 ? -back : back) - o.z) / d.z;
    vec2 place = o.xy + t * d.xy;
    bool within = dot(place / inner, place / inner) > 1.0 && dot(place / outer, place / outer) < 1.0;
    if (t > 0.0 && t < hit.t && within) hit = Hit(t, WINDOW_FRAME + w, vec3(0, 0, -sign(d.z)));
  }
}
#endif

// The frame of a window. o and d are in the window's coordinates.
void meetFrame(int w, vec3 o, vec3 d, inout Hit hit) {
  float back = windowDepth[w] / 2.0;
  if (back == 0.0) return;
#ifdef ROUND_WINDOWS
  if (windowRound[w]) {
    meetRing(w, o, d, hit);
    return;
  }
#endif
  vec2 half_ = windowHalf[w];
  // A ray that comes through the opening can only meet the opening's four inner faces.
  float entry = max(((d.z > 0.0 ? -back : back) - o.z) / d.z, 0.0);
  vec3 place = o + entry * d;
  if (max(abs(place.x) - half_.x, abs(place.y) - half_.y) <= 0.0) {
    vec2 reach = (sign(d.xy) * half_ - o.xy) / d.xy;
    float t = d.x == 0.0 || reach.y < reach.x ? reach.y : reach.x;
    if (t < hit.t && t >= entry && abs(o.z + t * d.z) < back) {
      hit = Hit(t, WINDOW_FRAME + w, t == reach.y ? vec3(0, -sign(d.y), 0) : vec3(-sign(d.x), 0, 0));
    }
    return;
  }
  float rim = windowFramed[w] ? frameRim : 0.0, slant = min(rim, windowDepth[w]);
  vec3 corner = vec3(half_ + rim, back);
  vec2 reach = boxed(o, d, -corner, corner);
  if (reach.x > reach.y || reach.y < 0.0 || reach.x > hit.t) return;
  if (rim == 0.0) {
    if (reach.x > 0.0) hit = Hit(reach.x, WINDOW_FRAME + w, faceNormal((o + reach.x * d) / corner));
    return;
  }
  // the cross-section's corners, from the opening's front to its back: distance from the opening, and z (templates/window_frame.pov.j2)
  vec2 section[6] = vec2[](
    vec2(0, -back), vec2(0.6 * rim, -back), vec2(0.75 * rim, 0.25 * slant - back), vec2(rim, 0.5 * slant - back),
    vec2(rim, back), vec2(0, back));
  for (int k = 1; k < 6; k++) meetFrameFace(w, o, d, section[k - 1], section[k], hit);
}

void meetFrames(vec3 o, vec3 d, inout Hit hit) {
  EACH_WINDOW(w) {
    float before = hit.t;
    meetFrame(w, toWindow(w, o - windowPlace[w]), toWindow(w, d), hit);
    if (hit.t < before) hit.normal = fromWindow(w, hit.normal);
  }
}
