// The mean of each pixel's rays, as sRGB, enlarged to the canvas. What is transparent shows the page behind it.

uniform sampler2D sum;
uniform vec2 size;    // of the picture in `sum`, pixels
uniform float rays;   // of each of its pixels
uniform vec2 canvas;  // its size, pixels
uniform vec2 corner;  // where it begins
out vec4 result;

vec4 light(ivec2 at) {
  return texelFetch(sum, clamp(at, ivec2(0), ivec2(size) - 1), 0) / rays;
}

void main() {
  vec2 place = (gl_FragCoord.xy - corner) / canvas * size - 0.5;
  ivec2 at = ivec2(floor(place));
  vec2 part = place - floor(place);
  vec4 mean = mix(
    mix(light(at), light(at + ivec2(1, 0)), part.x), mix(light(at + ivec2(0, 1)), light(at + ivec2(1, 1)), part.x), part.y);
  vec3 c = mean.rgb / max(mean.a, 1e-6);
  c = mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, greaterThan(c, vec3(0.0031308)));
  result = vec4(c * mean.a, mean.a);
}
