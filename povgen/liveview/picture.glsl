// One more ray for each pixel, added to the picture so far: the sum of the colours, and the number of rays that are not
// transparent.

uniform sampler2D sum;
uniform bool first;  // the picture begins anew
out vec4 result;

void main() {
  vec4 before = first ? vec4(0) : texelFetch(sum, ivec2(gl_FragCoord.xy), 0);
  Seen seen = see(placeOf(gl_FragCoord.xy));
  vec4 light = colourOf(seen);
  result = before + light;
}
