// Materials, sky and lights. Each function has the name of the texture, pigment or function in templates/*.pov.j2 that it
// repeats. Colours are linear light, 0 to 1. Points are in tiles.

struct Finish {
  vec3 pigment;
  float ambient, diffuse, specular, roughness;
  bool metallic;
};

#if PIECES > 0
uniform vec3 pieceColour[PIECES];  // sRGB, 0 to 1
#endif
#if SPHERES > 0
uniform int sphereCount;  // at most SPHERES; the radii of the others are 0
#endif

const float PI = 3.14159265358979;

// sRGB, as POV-Ray's `srgb`, to linear light.
vec3 srgb(vec3 c) {
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}

// POV-Ray's color_map with entries at 0, `middle` and 1.
vec3 colorMap(float value, float middle, vec3 a, vec3 b, vec3 c) {
  return value < middle ? mix(a, b, value / middle) : mix(b, c, (value - middle) / (1.0 - middle));
}

// ---- floor.pov.j2 ----
float StoneVein(float x, float z) {
  return abs(sin(1.3 * x + 0.9 * z + 1.9 * sin(0.9 * z - 0.5 * x) + 0.9 * sin(2.3 * x + 1.7 * z)
    + 0.35 * sin(5.3 * z - 4.1 * x) + 0.15 * sin(13.0 * x + 9.0 * z)));
}

Finish FloorTexture(vec3 p) {
  vec2 at = p.xz - vec2(0.5, 0);
  vec2 tile = floor(at);
  vec3 pigment = mod(tile.x + tile.y, 2.0) == 0.0
    ? colorMap(StoneVein(at.y, at.x), 0.06, vec3(0.20, 0.25, 0.23), vec3(0.085, 0.125, 0.115), vec3(0.055, 0.085, 0.078))
    : colorMap(StoneVein(at.x, at.y), 0.06, vec3(0.58, 0.50, 0.40), vec3(0.76, 0.71, 0.61), vec3(0.82, 0.78, 0.69));
  float nearness = 1.0 - length(p - vec3(0, floorY, 0)) / 120.0;
  pigment = mix(vec3(0.43, 0.42, 0.37), pigment, clamp((nearness - 0.1) / 0.8, 0.0, 1.0));
  return Finish(pigment, 0.10, 0.72, 0.15, 0.03, false);
}

// ---- frame.pov.j2 ----
Finish FrameTexture(vec3 p) {
  // each side's texture is that of the upper side, turned
  vec2 q = abs(p.x) > abs(p.y) ? (p.x < 0.0 ? vec2(p.y, -p.x) : vec2(-p.y, p.x)) : (p.y > 0.0 ? p.xy : -p.xy);
  float beyond = q.y - window / 2.0;
  float z = p.z - windowZ[0];  // from the middle of the nearest window
  for (int w = 1; w < WINDOWS; w++) if (abs(p.z - windowZ[w]) < abs(z)) z = p.z - windowZ[w];
  if (beyond > 0.0 && beyond < frameLip && z < 1e-4 - frameDepth / 2.0) {
    return Finish(vec3(0.85, 0.58, 0.22), 0.2, 0.55, 0.8, 0.04, true);  // LipTexture
  }
  float fibre = 0.5 + 0.5 * sin(60.0 * q.y + 40.0 * z + 1.5 * sin(2.1 * q.x + 3.0 * q.y) + 0.7 * sin(5.3 * q.x));
  return Finish(mix(vec3(0.080, 0.032, 0.015), vec3(0.160, 0.066, 0.028), fibre), 0.12, 0.8, 0.5, 0.02, false);
}

// ---- pedestal.pov.j2; the point is relative to the middle of the pedestal's foot ----
Finish PlinthTexture(vec3 p) {
  float vein = abs(sin(1.9 * p.x + 2.3 * p.y + 1.7 * p.z + 1.9 * sin(1.3 * p.y - 1.9 * p.x)
    + 0.7 * sin(4.0 * p.x + 3.0 * p.z - 3.0 * p.y) + 0.2 * sin(17.0 * p.x + 13.0 * p.y)));
  vec3 pigment = colorMap(vein, 0.08, vec3(0.70, 0.70, 0.68), vec3(0.40, 0.42, 0.43), vec3(0.33, 0.35, 0.37));
  return Finish(pigment, 0.12, 0.75, 0.2, 0.03, false);
}

// ---- wood.pov.j2; the point is relative to the middle of the piece's foot ----
float Trunk(vec3 p) {
  return length(vec2(
    p.x - 1.45 + 0.16 * sin(1.3 * p.y) + 0.03 * sin(5.1 * p.y + 4.0 * p.z), p.z - 0.9 - 0.12 * sin(1.9 * p.y + 1.0)));
}

float Rings(vec3 p) {
  return 0.5 + 0.36 * sin(2.0 * PI * 13.0 * Trunk(p) + 1.6 * sin(2.0 * PI * 2.7 * Trunk(p)))
    + 0.14 * sin(150.0 * p.x + 5.0 * sin(1.3 * p.y)) * sin(130.0 * p.z + 4.0 * sin(1.7 * p.y));
}

Finish Wood(vec3 color, vec3 p) {
  vec3 dark = srgb(color * vec3(0.78, 0.70, 0.62)), middle = srgb(color * vec3(0.95, 0.92, 0.89));
  return Finish(colorMap(Rings(p), 0.4, dark, middle, srgb(color)), 0.14, 0.78, 0.7, 0.018, false);
}

// ---- spheres.pov.j2 ----
vec3 SphereColor(float t) {
  const vec3 a = vec3(1.00, 0.74, 0.00), b = vec3(0.95, 0.24, 0.01), c = vec3(0.75, 0.02, 0.03);
  const vec3 d = vec3(0.45, 0.01, 0.28), e = vec3(0.08, 0.01, 0.22);
  if (t < 0.30) return mix(a, b, t / 0.30);
  if (t < 0.55) return mix(b, c, (t - 0.30) / 0.25);
  return t < 0.78 ? mix(c, d, (t - 0.55) / 0.23) : mix(d, e, (t - 0.78) / 0.22);
}

Finish finishOf(int what, vec3 p) {
  if (what == FLOOR) return FloorTexture(p);
#if PIECES > 0
  if (what >= OBJECT + PIECES) {
    vec3 foot = pieceFoot[what - OBJECT - PIECES];
    return PlinthTexture(p - vec3(foot.x, floorY, foot.z));
  }
  if (what >= OBJECT) return Wood(pieceColour[what - OBJECT], p - pieceFoot[what - OBJECT]);
#endif
#if SPHERES > 0
  if (what >= OBJECT) return Finish(SphereColor(float(what - OBJECT) / float(sphereCount)), 0.15, 0.75, 0.5, 0.02, false);
#endif
  return FrameTexture(p);
}

// ---- light.pov.j2 ----
// The sun is a row of 7 lights. Each of a pixel's rays asks for the shadow of one of them; those at the ends count half.
const vec3 sunDirection = vec3(-1000, 1300, -550), sunColour = vec3(1.02, 0.95, 0.82), sunRow = vec3(70, 50, 20);
const vec3 fillDirection = vec3(900, 500, -1200), fillColour = vec3(0.26, 0.30, 0.36);
uniform int rayNumber;

vec3 shadowDirection() {
  float place = fract(0.5 + float(rayNumber) * 0.6180339887);
  return normalize(sunDirection + (floor(place * 6.0 + 0.5) / 6.0 - 0.5) * sunRow);
}

// ---- sky.pov.j2 ----
const int BLACK = 1, WHITE = 2, TRANSPARENT = 3;
uniform int background;  // one of these; 0: the sky

float Zigzag(float t) { return 1.0 - 2.0 * abs(t - floor(t + 0.5)); }

float Mountain(float a) {
  return 0.020 + 0.068 * Zigzag(5.0 * a - 0.274) + 0.050 * Zigzag(11.0 * a + 0.398) + 0.020 * Zigzag(26.0 * a + 0.127)
    + 0.008 * Zigzag(67.0 * a + 0.318);
}

float SnowLine(float a) {
  return 0.070 + 0.022 * Zigzag(17.0 * a) - 0.030 * Zigzag(41.0 * a + 0.191) + 0.012 * Zigzag(97.0 * a + 0.318);
}

float Foothill(float a) {
  return 0.016 + 0.010 * sin(7.0 * PI * a + 2.5) + 0.005 * sin(17.0 * PI * a + 1.0) + 0.002 * sin(43.0 * PI * a);
}

float Above(float d) { return clamp(0.5 + d / 0.002, 0.0, 1.0); }

float Sunlit(float a, float rise) {
  float d = 0.0013 + 0.08 * (Mountain(a) - rise);
  return clamp(0.5 + 60.0 * (Mountain(a + d) - Mountain(a - d)), 0.0, 1.0);
}

vec3 SkyPigment(float y) {
  const vec3 a = vec3(0.72, 0.83, 0.92), b = vec3(0.46, 0.66, 0.88), c = vec3(0.16, 0.36, 0.70), d = vec3(0.05, 0.16, 0.44);
  if (y < 0.08) return mix(a, b, y / 0.08);
  return y < 0.33 ? mix(b, c, (y - 0.08) / 0.25) : mix(c, d, min((y - 0.33) / 0.38, 1.0));
}

vec3 FarPigment(float y, float azimuth, float rise) {
  float sunlit = Sunlit(azimuth, rise);
  vec3 rock = mix(vec3(0.10, 0.15, 0.26), vec3(0.27, 0.29, 0.34), sunlit);
  vec3 snow = mix(vec3(0.42, 0.54, 0.74), vec3(1.00, 0.98, 0.95), sunlit);
  vec3 mountain = mix(rock, snow, Above(rise - SnowLine(azimuth)));
  return mix(mountain, SkyPigment(y), Above(rise - Mountain(azimuth)));
}

// The direction d is a unit vector.
vec3 skyColour(vec3 d) {
  if (background == BLACK || background == WHITE) return vec3(background - BLACK);
  if (d.y > 0.168) return SkyPigment(d.y);
#if PIECES == 0
  if (d.y < 0.0) return colorMap(-d.y, 0.15, vec3(0.20, 0.17, 0.11), vec3(0.12, 0.11, 0.08), vec3(0.05, 0.05, 0.04));
#endif
  float azimuth = atan(d.x, d.z) / PI, rise = d.y / sqrt(d.x * d.x + d.z * d.z + 1e-6);
  vec3 far = FarPigment(d.y, azimuth, rise);
  if (d.y > 0.034) return far;
  vec3 foothill = mix(vec3(0.66, 0.72, 0.68), vec3(0.19, 0.33, 0.25), clamp(rise / 0.03, 0.0, 1.0));
  return mix(foothill, far, Above(rise - Foothill(azimuth)));
}
