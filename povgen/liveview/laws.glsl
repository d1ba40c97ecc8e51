// The laws of ideal sheets, from povgen/sheets/: the direction of an eye's ray behind a sheet. Where no light passes, z is not
// positive.

uniform int kind[WINDOWS];                       // of the sheet in each window: a number in `bent`; -1: prisms; -2: none
#ifdef LAWS
uniform float constants[WINDOWS * CONSTANTS];    // of each window's law: what depends on its parameters alone

vec3 bent(vec3 d, vec2 place, int number) {
  float x = d.x, y = d.y, z = d.z, X = place.x, Y = place.y;
  int at = number * CONSTANTS;
  vec3 found = vec3(0);  // no light
  switch (kind[number]) {
{% for law in laws %}
    case {{ loop.index0 }}: found = vec3({{ law.glsl | join(", ") }}); break;  // {{ law.name.split(" ")[0] }}
{% endfor %}
  }
  if (!(found.z > 0.0)) return vec3(0, 0, -1);
  found /= max(max(abs(found.x), abs(found.y)), found.z);  // squares of very large or small numbers are inf or 0
  return found.z > 1e-6 * length(found) ? normalize(found) : vec3(0, 0, -1);
}

#ifdef FROM_BEHIND
// The slope x/z, y/z behind a sheet of a ray that has the slope `before` it. Far from 0 where no light passes.
vec2 slopeBehind(vec2 before, vec2 place, int number) {
  vec3 d = bent(normalize(vec3(before, 1)), place, number);
  return d.z > 0.0 ? d.xy / d.z : vec2(1e9);
}

// The direction, before a sheet, of a ray that comes from behind it: a path of light runs both ways. The slope before the
// sheet is found by Newton's method, whose derivatives are differences.
vec3 bentFromBehind(vec3 d, vec2 place, int number) {
  const float STEP = 0.004;
  vec2 wanted = d.xy / d.z, slope = wanted;
  float off = 1e9;
  for (int k = 0; k < 20 && off > 1e-6; k++) {
    vec2 miss = slopeBehind(slope, place, number) - wanted;
    off = length(miss) / (1.0 + length(wanted));
    vec2 ahead = slopeBehind(slope + vec2(STEP, 0), place, number), back = slopeBehind(slope - vec2(STEP, 0), place, number);
    vec2 above = slopeBehind(slope + vec2(0, STEP), place, number), below = slopeBehind(slope - vec2(0, STEP), place, number);
    mat2 change = mat2((ahead - back) / (2.0 * STEP), (above - below) / (2.0 * STEP));
    if (off > 1e-6) slope -= inverse(change) * miss;
  }
  return off < 1e-4 ? -normalize(vec3(slope, 1)) : vec3(0, 0, 1);  // (0, 0, 1): no light
}
#endif
#endif
