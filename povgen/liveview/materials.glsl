// Materials, sky and lights. Numbers, colour maps and formulas are those of the .pov text: povgen/scene/materials.py. Colours
// are linear light, 0 to 1. Points are in tiles.

// sRGB, as POV-Ray's `srgb`, to linear light.
vec3 srgb(vec3 c) {
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}

// ---- colour maps and formulas ----
{% for name, colours in materials.COLOUR_MAPS.items() %}
vec3 {{ name }}(float value) { return {{ colours | interpolated }}; }
{% endfor %}

const float PI = 3.14159265358979, pi = PI;  // pi in formulas
float Trunk(float x, float y, float z);
{% for head, text in materials.FORMULAS.items() %}
float {{ head | replace("(", "(float ") | replace(", ", ", float ") }} { return {{ text | floats }}; }
{% endfor %}
float Trunk(float x, float y, float z) { return length(vec2(TrunkX(x, y, z), TrunkZ(y, z))); }

// ---- floor.pov.j2 ----
#ifdef FLOOR_PICTURE
uniform sampler2D floorPicture;
uniform vec2 floorTiles;  // width and height of a copy
uniform vec3 floorMean;   // the mean colour
#endif
Finish FloorTexture(vec3 p) {
#ifdef FLOOR_PICTURE
  vec3 pigment = textureLod(floorPicture, vec2(p.x, -p.z) / floorTiles, 0.0).rgb, mean = floorMean;
#else
  vec3 mean = vec3({{ materials.FADE.colour }});
  vec2 at = p.xz - vec2(0.5, 0);
  vec2 tile = floor(at);
  vec3 pigment = mod(tile.x + tile.y, 2.0) == 0.0
    ? DarkTile(StoneVein(at.y, 0.0, at.x)) : LightTile(StoneVein(at.x, 0.0, at.y));
#endif
  float nearness = 1.0 - length(p - vec3(0, floorY, 0)) / {{ materials.FADE.distance | floats }};
  float share = clamp((nearness - {{ materials.FADE.gone }}) / ({{ materials.FADE.whole }} - {{ materials.FADE.gone }}), 0.0, 1.0);
  return Finish(mix(mean, pigment, share), {{ materials.FINISHES.floor | join(", ") }}, false);
}

// ---- window_frame.pov.j2; p is in the window's coordinates ----
Finish FrameTexture(int w, vec3 p) {
  if (!windowFramed[w]) return Finish(vec3(0), 0.0, 0.0, 0.0, 1.0, false);
  // each side's texture is that of the upper side, turned
  vec2 beside = abs(p.xy) - windowHalf[w];
  vec2 q = beside.x > beside.y ? (p.x < 0.0 ? vec2(p.y, -p.x) : vec2(-p.y, p.x)) : (p.y > 0.0 ? p.xy : -p.xy);
  bool lip = max(beside.x, beside.y) < 0.2 * frameRim;
#ifdef ROUND_WINDOWS
  if (windowRound[w]) {
    q = p.xy;
    lip = length(p.xy / (windowHalf[w] + 0.2 * frameRim)) < 1.0;
  }
#endif
  if (lip && !isInWindow(w, p.xy) && p.z < 1e-4 - windowDepth[w] / 2.0) {
    return Finish(vec3({{ materials.LIP }}), {{ materials.FINISHES.lip | join(", ") }}, true);
  }
  float fibres = Fibres(q.x, q.y, p.z);
  return Finish(w > 0 ? FurtherFrame(fibres) : Frame(fibres), {{ materials.FINISHES.frame | join(", ") }}, false);
}

// ---- pedestal.pov.j2; p is from the middle of the foot ----
Finish PlinthTexture(vec3 p) {
  return Finish(Plinth(PlinthVein(p.x, p.y, p.z)), {{ materials.FINISHES.plinth | join(", ") }}, false);
}

// ---- piece_wood.pov.j2; p is from the middle of the foot ----
Finish Wood(vec3 color, vec3 p) {
  float value = Rings(p.x, p.y, p.z);
  vec3 pigment = {{ materials.WOOD | interpolated("srgb(color * vec3({}))") }};
  return Finish(pigment, {{ materials.FINISHES.wood | join(", ") }}, false);
}

// ---- povgen/objects/ ----
const vec3 CARD_BACK = vec3({{ materials.CARD_BACK }});
Finish PlainTexture(vec3 pigment) { return Finish(pigment, {{ materials.FINISHES.sphere | join(", ") }}, false); }
Finish CardTexture(vec3 pigment) { return Finish(pigment, {{ materials.FINISHES.card | join(", ") | floats }}, false); }

// ---- light.pov.j2 ----
// Each of a pixel's rays asks for the shadow of one of the sun's lights; those at the ends of the row count half.
{% set sun, sky, ground = materials.SUN, materials.SKY_LIGHT, materials.FLOOR_LIGHT %}
const vec3 sunDirection = vec3({{ sun.direction }}), sunColour = vec3({{ sun.colour }}), sunRow = vec3({{ sun.row }});
const vec3 skyDirection = vec3({{ sky.direction }}), skyLight = vec3({{ sky.colour }});
const vec3 groundDirection = vec3({{ ground.direction }}), groundLight = vec3({{ ground.colour }});
uniform int rayNumber;

vec3 shadowDirection() {
  float place = fract(0.5 + float(rayNumber) * 0.6180339887), last = {{ sun.lights - 1 }}.0;
  return normalize(sunDirection + (floor(place * last + 0.5) / last - 0.5) * sunRow);
}

// ---- sky.pov.j2 ----
const int BLACK = 1, WHITE = 2, TRANSPARENT = 3;
uniform int background;  // one of these; 0: the sky

#ifdef SKY_PICTURE
uniform sampler2D skyPicture;
#else
uniform sampler2D mountains;
#endif

{% set strip = materials.PANORAMA %}
// The direction d is a unit vector.
vec3 skyColour(vec3 d) {
  if (background == BLACK || background == WHITE) return vec3(background - BLACK);
#ifdef SKY_PICTURE
  return textureLod(skyPicture, vec2(0.5 + atan(d.x, d.z) / (2.0 * pi), 0.5 - asin(clamp(d.y, -1.0, 1.0)) / pi), 0.0).rgb;
#else
  if (d.y < 0.0) return PlainPigment(-d.y);
  float row = (d.y - {{ strip.low }}) / ({{ strip.high }} - {{ strip.low }});
  vec3 mountain = textureLod(mountains, vec2(0.5 + atan(d.x, d.z) / (2.0 * pi), 1.0 - row), 0.0).rgb;
  return mix(mountain, SkyPigment(d.y), clamp((d.y - {{ strip.whole }}) / ({{ strip.gone }} - {{ strip.whole }}), 0.0, 1.0));
#endif
}
