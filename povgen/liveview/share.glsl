// The rays of a picture, one for each pixel, at the same place in every pixel: each is shared between the four pixels whose
// centres are nearest, the more the nearer (a triangle filter, as in povgen/rendering/light.py).

uniform sampler2D picture;  // has one more pixel at every edge
uniform vec2 jitter;        // the rays' place in their pixels, from the centre, pixels
out vec4 result;

vec4 ray(ivec2 at) {
  return texelFetch(picture, at, 0);
}

void main() {
  vec2 place = gl_FragCoord.xy + 0.5 - jitter;
  ivec2 at = ivec2(floor(place));
  vec2 part = place - vec2(at);
  result = mix(mix(ray(at), ray(at + ivec2(1, 0)), part.x), mix(ray(at + ivec2(0, 1)), ray(at + ivec2(1, 1)), part.x), part.y);
}
