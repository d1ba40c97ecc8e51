// Rays through a window of prisms or lenses, in the window's coordinates, as povgen/optics/trace.py follows them.

uniform sampler2D starts;  // a point of each ray, and how many faces it may meet
uniform sampler2D ways;    // its direction
layout(location = 0) out vec4 position;   // where the ray leaves the sheets, or ends; and how it ends
layout(location = 1) out vec4 direction;  // its last direction, and how many faces it has met
layout(location = 2) out vec4 path;       // whether it is the designed one; `orders`

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 start = texelFetch(starts, at, 0);
  vec3 d = texelFetch(ways, at, 0).xyz;
  int before = maxFaces - int(start.w);
  pathStep = d.z > 0.0 ? 1 : -1;
  pathPlace = d.z > 0.0 ? 0 : PATH - 1;
  Passage ray = passage(Passage(start.xyz, d, THROUGH, before), 0);
  vec3 p = ray.position, v = ray.direction;
  if (ray.end == THROUGH || ray.end == BACK) {
    ray.end = v.z * d.z > 0.0 ? THROUGH : BACK;
    float way = max((sign(v.z) * windowDepth[0] / 2.0 - p.z) / v.z, 0.0);  // to the end of the frame
    if (!isInWindow(0, p.xy + way * v.xy)) ray.end = FRAME;
  }
  bool designed = ray.end == THROUGH && onPath && ray.faces - before == PATH && orders == vec2(0);
  position = vec4(p, ray.end);
  direction = vec4(v, ray.faces - before);
  path = vec4(designed, orders, 0);
}
