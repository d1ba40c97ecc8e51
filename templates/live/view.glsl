// What the eye sees in a pixel: one ray from the eye through the sheets to what stands behind them, and its colour.

uniform int model;           // of the sheets: 0 none, 1 ideal, 2 prisms
uniform vec2 alpha;          // cosine and sine of the ray-rotation angle
uniform vec3 eye;
uniform float viewHeight;    // height of the picture in the plane z = 0, tiles
uniform vec2 size;           // of the picture, pixels
uniform vec2 jitter;         // the ray's place in its pixel, from the centre, pixels

struct Seen {
  vec3 origin, direction;  // of the ray that leaves the sheets; without sheets, of the eye's ray
  Hit hit;                 // what this ray meets first
  bool lost;               // the ray has met too many faces
  Passage passage;         // through the prisms
};

// Where a pixel's ray crosses the plane z = 0.
vec3 placeOf(vec2 pixel) {
  return vec3((pixel + jitter - size / 2.0) / size.y * viewHeight, 0);
}

// Whether the ray passes the window frame's front opening, and then the window at z, within the frame.
bool entersWindow(vec3 place, vec3 d, float z) {
  vec2 front = abs(place.xy - d.xy / d.z * frameDepth / 2.0), at = abs(place.xy + d.xy / d.z * z);
  return max(max(front.x, front.y), max(at.x, at.y)) < window / 2.0;
}

// What the eye sees at a place in the plane z = 0. Rays to the sheets start there, not at the eye: a far eye's distance,
// in pitches, would have too many digits.
Seen see(vec3 place) {
  Seen seen;
  vec3 d = normalize(place - eye);
  seen.origin = eye;
  seen.direction = d;
  seen.lost = false;
  seen.passage = Passage(eye, d, THROUGH, 0, 0.0);
  float front = model == 2 ? (sheetCentre[0] - prismHalf * pitch) : 0.0;
  if (model > 0 && entersWindow(place, d, front)) {
    if (model == 1) {
      seen.origin = place;
      // A camera's ray runs against the light: it is turned by -alpha.
      seen.direction = vec3(alpha.x * d.x + alpha.y * d.y, alpha.x * d.y - alpha.y * d.x, d.z);
    } else {
      seen.passage = passage(place, d);
      seen.origin = seen.passage.position;
      seen.direction = seen.passage.direction;
      seen.lost = seen.passage.end == UNFINISHED;
      if (seen.passage.end == FRAME) {
        vec2 inwards = abs(seen.origin.x) > abs(seen.origin.y) ? vec2(-sign(seen.origin.x), 0) : vec2(0, -sign(seen.origin.y));
        seen.hit = Hit(0.0, WINDOW_FRAME, vec3(inwards, 0));
        return seen;
      }
    }
  }
  if (seen.lost) seen.hit = Hit(0.0, SKY, vec3(0));
  else seen.hit = meet(seen.origin, seen.direction);
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
  return vec4(min(finish.pigment * light + highlight, 1.0), 1);
}
