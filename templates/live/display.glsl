// The mean of each pixel's rays, as sRGB, enlarged to the canvas.

uniform sampler2D sum;
uniform vec2 canvas;  // its size, pixels
out vec4 result;

vec3 light(ivec2 at) {
  vec4 rays = texelFetch(sum, clamp(at, ivec2(0), textureSize(sum, 0) - 1), 0);
  return rays.rgb / rays.a;
}

void main() {
  vec2 place = gl_FragCoord.xy / canvas * vec2(textureSize(sum, 0)) - 0.5;
  ivec2 at = ivec2(floor(place));
  vec2 part = place - floor(place);
  vec3 c = mix(
    mix(light(at), light(at + ivec2(1, 0)), part.x), mix(light(at + ivec2(0, 1)), light(at + ivec2(1, 1)), part.x), part.y);
  result = vec4(mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, greaterThan(c, vec3(0.0031308))), 1);
}
