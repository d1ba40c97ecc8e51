// Numbers for each pixel, to measure the view.

layout(location = 0) out vec4 ray;     // the direction that leaves the sheets, and how the ray ends there
layout(location = 1) out vec4 path;    // SKY, FLOOR ... or -1 if lost; how many faces; which; how far to the hit
layout(location = 2) out vec4 place;   // the point that the pixel shows, and 1 if it is one

void main() {
  Seen seen = see(placeOf(gl_FragCoord.xy));
  ray = vec4(seen.direction, seen.passage.end);
  path = vec4(seen.lost ? -1 : seen.hit.what, seen.passage.faces, seen.passage.path, seen.hit.t);
  place = vec4(seen.origin + seen.hit.t * seen.direction, seen.hit.what == SKY ? 0 : 1);
}
