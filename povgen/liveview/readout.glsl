// Numbers for each pixel, to measure the view.

layout(location = 0) out vec4 ray;    // the direction that leaves the sheets, and how the ray ends there
layout(location = 1) out vec4 shown;  // SKY, FLOOR ... or -1 if lost; where the ray leaves the sheets
layout(location = 2) out vec4 met;    // the point that the pixel shows, tiles, and 1; 0 for the sky and if lost

void main() {
  Seen seen = see(placeOf(gl_FragCoord.xy));
  ray = vec4(seen.direction, seen.passage.end);
  shown = vec4(seen.lost ? -1 : seen.hit.what, seen.origin);
  met = seen.lost || seen.hit.what == SKY ? vec4(0) : vec4(seen.origin + seen.hit.t * seen.direction, 1);
}
