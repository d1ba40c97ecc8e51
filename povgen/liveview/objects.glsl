// The objects, and where a ray meets them. Lengths are in tiles.
//
// An object has coordinates of its own (povgen/objects/), from its place, along its axes. The functions of each kind of
// object, reach_KIND and others, are in that kind's file. ALL_KIND has the numbers of its objects: from the first up to the
// second.

#if OBJECTS > 0
uniform vec3 objectPlace[OBJECTS];
uniform vec4 objectNumbers[OBJECTS];   // `numbers` of the object's file
uniform vec3 objectColour[OBJECTS];    // sRGB, 0 to 1
#ifdef TURNED_OBJECTS
uniform mat3 objectAxes[OBJECTS];      // the axes of each object: its columns
#endif
#endif

{% for name, text in objects.items() %}
{{ "#ifdef ALL_%s" | format(name.upper()) }}
{{ text.strip() }}
#endif
{% endfor %}

#if OBJECTS > 0
vec3 toObject(int k, vec3 v) {
#ifdef TURNED_OBJECTS
  return v * objectAxes[k];
#else
  return v;
#endif
}

// The first object that a ray meets before it has gone as far as `most`, which becomes how far away it is; -1: none.
int objectMet(vec3 o, vec3 d, inout float most) {
  int met = -1;
{% for name in objects %}
{{ "#ifdef ALL_%s" | format(name.upper()) }}
  for (int k = ALL_{{ name | upper }}.x; k < ALL_{{ name | upper }}.y; k++) {
    float t = reach_{{ name }}(toObject(k, o - objectPlace[k]), toObject(k, d), objectNumbers[k], most);
    if (t < most) {
      most = t;
      met = k;
    }
  }
#endif
{% endfor %}
  return met;
}

bool isIn(ivec2 several, int k) { return several.x <= k && k < several.y; }

vec3 normalOf(int k, vec3 p) {
  p = toObject(k, p - objectPlace[k]);
  vec4 n = objectNumbers[k];
  vec3 found = vec3(0, 0, 1);
{% for name in objects %}
{{ "#ifdef ALL_%s" | format(name.upper()) }}
  if (isIn(ALL_{{ name | upper }}, k)) found = normal_{{ name }}(p, n);
#endif
{% endfor %}
#ifdef TURNED_OBJECTS
  found = objectAxes[k] * found;
#endif
  return found;
}

// Its material at a point.
Finish materialOf(int k, vec3 p) {
  p = toObject(k, p - objectPlace[k]);
  vec4 n = objectNumbers[k];
{% for name in objects %}
{{ "#ifdef ALL_%s" | format(name.upper()) }}
  if (isIn(ALL_{{ name | upper }}, k)) return finish_{{ name }}(p, n, objectColour[k]);
#endif
{% endfor %}
  return Finish(vec3(0), 0.0, 0.0, 0.0, 1.0, false);
}
#endif

// The first surface that a ray meets before it has gone as far as `most`, otherwise the sky.
Hit meet(vec3 o, vec3 d, float most) {
  Hit hit = Hit(most, SKY, vec3(0));
  float below = (floorY - o.y) / d.y;
  if (hasFloor && d.y < 0.0 && below > 0.0 && below < min(most, horizon)) hit = Hit(below, FLOOR, vec3(0, 1, 0));
  meetFrames(o, d, hit);
#if OBJECTS > 0
  int met = objectMet(o, d, hit.t);
  if (met >= 0) {
    hit.what = OBJECT + met;
    hit.normal = normalOf(met, o + hit.t * d);
  }
#endif
  return hit;
}

// Whether something stands between a point and a light in this direction. The floor never does, nor does glass.
bool shadowed(vec3 o, vec3 d) {
  Hit hit = Hit(1e30, SKY, vec3(0));
  meetFrames(o, d, hit);
#if OBJECTS > 0
  return hit.what != SKY || objectMet(o, d, hit.t) >= 0;
#else
  return hit.what != SKY;
#endif
}
