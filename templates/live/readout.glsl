// Numbers for each pixel, to measure the view.

layout(location = 0) out vec4 ray;    // the direction that leaves the sheets, and how the ray ends there
layout(location = 1) out vec4 shown;  // SKY, FLOOR ... or -1 if lost; where the ray leaves the sheets

void main() {
  Seen seen = see(placeOf(gl_FragCoord.xy));
  ray = vec4(seen.direction, seen.passage.end);
  shown = vec4(seen.lost ? -1 : seen.hit.what, seen.origin);
}
