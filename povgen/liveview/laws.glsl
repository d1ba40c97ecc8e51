// The laws of ideal sheets, from povgen/sheets/: the direction of an eye's ray behind a sheet. Where no light passes, z is not
// positive.

uniform int kind[WINDOWS];                       // of the sheet in each window: a number in `bent`, or -1 for prisms
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
