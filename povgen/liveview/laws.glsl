// The laws of ideal sheets, from povgen/sheets/: the direction of an eye's ray behind a sheet. Where no light passes, z is not
// positive.

uniform int kind[WINDOWS];                       // of the sheet in each window: a number in `bent`; -1: prisms; -2: none
#ifdef LAWS
uniform float constants[WINDOWS * CONSTANTS];    // of each window's law: what depends on its parameters alone

// What a window's law makes of a direction, of any length.
vec3 lawOf(vec3 d, vec2 place, int number) {
  float x = d.x, y = d.y, z = d.z, X = place.x, Y = place.y;
  int at = number * CONSTANTS;
  switch (kind[number]) {
{% for law in laws %}
    case {{ loop.index0 }}: return vec3({{ law.glsl | join(", ") }});  // {{ law.name.split(" ")[0] }}
{% endfor %}
  }
  return vec3(0);  // no light
}

vec3 bent(vec3 d, vec2 place, int number) {
  vec3 found = lawOf(d, place, number);
  if (!(found.z > 0.0)) return vec3(0, 0, -1);
  found /= max(max(abs(found.x), abs(found.y)), found.z);  // squares of very large or small numbers are inf or 0
  return found.z > 1e-6 * length(found) ? normalize(found) : vec3(0, 0, -1);
}

#ifdef FROM_BEHIND
// The law for a vector of any length, which it does not change: where the law is linear, as of rotations and lenses, so is this.
vec3 scaledLaw(vec3 v, vec2 place, int number) {
  return length(v) * lawOf(normalize(v), place, number);
}

vec3 withSine(vec2 sine) {
  return vec3(sine, sqrt(max(1.0 - dot(sine, sine), 0.0)));
}

// The direction, before a sheet, of a ray that comes from behind it: a path of light runs both ways. It is found by Newton's
// method, with differences as derivatives. Many laws are linear in vectors of any length. Others, such as that of refraction,
// are nearly linear in the sine.
vec3 bentFromBehind(vec3 d, vec2 place, int number) {
  const vec2 STEP = vec2(0.004, 0);
  vec3 wanted = -d, before = wanted, miss;
  for (int k = 0; k < 20; k++) {
    miss = scaledLaw(before, place, number) - wanted;
    if (!(length(miss) > 2e-6)) break;
    mat3 change = mat3(
      scaledLaw(before + STEP.xyy, place, number) - scaledLaw(before - STEP.xyy, place, number),
      scaledLaw(before + STEP.yxy, place, number) - scaledLaw(before - STEP.yxy, place, number),
      scaledLaw(before + STEP.yyx, place, number) - scaledLaw(before - STEP.yyx, place, number)
    );
    before -= 2.0 * STEP.x * (inverse(change) * miss);
  }
  before = normalize(before);
  if (before.z > 0.0 && distance(bent(before, place, number), wanted) < 1e-4) return -before;
  vec2 sine = vec2(0);
  for (int k = 0; k < 20; k++) {
    vec2 off = bent(withSine(sine), place, number).xy - wanted.xy;
    if (!(length(off) > 2e-6)) break;
    mat2 change = mat2(
      bent(withSine(sine + STEP.xy), place, number).xy - bent(withSine(sine - STEP.xy), place, number).xy,
      bent(withSine(sine + STEP.yx), place, number).xy - bent(withSine(sine - STEP.yx), place, number).xy
    );
    sine -= 2.0 * STEP.x * (inverse(change) * off);
  }
  before = withSine(sine);
  bool found = before.z > 0.0 && distance(bent(before, place, number), wanted) < 1e-4;
  return found ? -before : vec3(0, 0, 1);  // (0, 0, 1): no light
}
#endif
#endif
