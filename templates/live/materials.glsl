// Materials, sky and lights. Each function is the texture of the same name in templates/*.pov.j2.
// Colours are linear light, 0 to 1. Points are in tiles.

struct Finish {
  vec3 pigment;
  float ambient, diffuse, specular, roughness;
};

#if PIECES > 0
uniform vec3 pieceColour[PIECES];  // sRGB, 0 to 1
#endif
#if SPHERES > 0
uniform int sphereCount;  // at most SPHERES; the radii of the others are 0
#endif

// sRGB, as POV-Ray's `srgb`, to linear light.
vec3 srgb(vec3 c) {
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}

// ---- floor.pov.j2 ----
Finish FloorTexture(vec3 p) {
  const vec3 LightTile = vec3(0.87, 0.82, 0.70), DarkTile = vec3(0.20, 0.27, 0.30), mean = vec3(0.44, 0.46, 0.44);
  vec2 tile = floor(p.xz - vec2(0.5, 0.0));
  bool dark = mod(tile.x + tile.y, 2.0) == 0.0;
  float nearness = 1.0 - length(p - vec3(0, floorY, 0)) / 120.0;
  vec3 pigment = mix(mean, dark ? DarkTile : LightTile, clamp((nearness - 0.1) / 0.8, 0.0, 1.0));
  return Finish(pigment, 0.12, 0.75, 0.0, 1.0);
}

// ---- frame.pov.j2 ----
Finish FrameTexture(vec3 p) {
  return Finish(vec3(0.07, 0.07, 0.08), 0.1, 0.8, 0.25, 0.03);
}

// ---- chess.pov.j2 ----
#if PIECES > 0
Finish PieceTexture(int piece, vec3 p) {
  return Finish(srgb(pieceColour[piece]), 0.12, 0.75, 0.5, 0.02);
}
#endif

// ---- spheres.pov.j2 ----
#if SPHERES > 0
Finish SphereTexture(int k) {
  vec3 pigment = vec3(0.35, 0.90, 0.10) * pow(0.15, float(k) / float(sphereCount)) + vec3(0.00, 0.03, 0.02);
  return Finish(pigment, 0.15, 0.7, 0.5, 0.02);
}
#endif

Finish finishOf(int what, vec3 p) {
  if (what == FLOOR) return FloorTexture(p);
  if (what == WINDOW_FRAME) return FrameTexture(p);
#if PIECES > 0
  return PieceTexture(what - OBJECT, p - pieceFoot[what - OBJECT]);
#elif SPHERES > 0
  return SphereTexture(what - OBJECT);
#else
  return FrameTexture(p);
#endif
}

// ---- light.pov.j2 ----
const int LIGHTS = 2;
const bool castsShadows[LIGHTS] = bool[](true, false);
const vec3 lightColour[LIGHTS] = vec3[](vec3(1.00, 0.96, 0.88), vec3(0.30, 0.34, 0.40));

vec3 towardsLight(int light, vec3 p) {
  return normalize(light == 0 ? vec3(-900, 1400, -350) : vec3(500, 500, -1500));
}

// ---- sky.pov.j2; for spheres, spheres.pov.j2 ----
uniform int background;  // 0: the scene's own sky; 1: black; 2: white

vec3 skyColour(vec3 d) {
  if (background > 0) return vec3(background == 2 ? 1 : 0);
  const vec3 pale = vec3(0.86, 0.90, 0.93), blue = vec3(0.50, 0.68, 0.88), deep = vec3(0.17, 0.35, 0.66);
#if PIECES > 0
  return d.y < 0.25 ? mix(pale, blue, max(d.y, 0.0) / 0.25) : mix(blue, deep, min((d.y - 0.25) / 0.45, 1.0));
#else
  if (d.y < 0.0) return mix(vec3(0.10, 0.11, 0.13), vec3(0.36, 0.38, 0.40), d.y + 1.0);
  return d.y < 0.24 ? mix(pale, blue, d.y / 0.24) : mix(blue, deep, min((d.y - 0.24) / 0.46, 1.0));
#endif
}
