// One more ray for each pixel, added to the picture so far: the sum of the colours, and the number of rays that are not
// transparent.

uniform sampler2D sum;
uniform bool first;  // the picture begins anew
uniform int side;    // for red and cyan glasses: -1 is the left eye's red light, 1 the right eye's green and blue; 0: all
out vec4 result;

void main() {
  vec4 before = first ? vec4(0) : texelFetch(sum, ivec2(gl_FragCoord.xy), 0);
  Seen seen = see(placeOf(gl_FragCoord.xy));
  vec4 light = colourOf(seen);
  if (side != 0) light.rgb *= side < 0 ? vec3(2, 0, 0) : vec3(0, 2, 2);  // each is in half of the rays
  result = before + light;
}
