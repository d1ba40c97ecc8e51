// The shapes of prisms and lenses in a window, as in povgen/optics/prism.py and povgen/optics/profile.py. Lengths are in tiles,
// angles in degrees.

import { hasPrisms } from "./sheets.js";

export const radians = (degrees) => degrees * (Math.PI / 180);

// The shape of the prisms with these values of a window: povgen/optics/prism.py.
export function prism(values) {
  const { aperture, prisms, index, design_index = index, base_angle, gap } = values;
  const pitch = aperture / prisms;
  const base = radians(base_angle);
  const fullAperture = (n) => 1 / Math.tan(base) + 1 / Math.tan(Math.PI / 2 - base - Math.asin(Math.cos(base) / n));
  const height = pitch * (1 - gap);
  const length = height * values.aspect * fullAperture(design_index);
  const aspect = values.aspect * (fullAperture(design_index) / fullAperture(index));
  return {
    pitch, height, length, index,
    slab_shift: height * aspect * Math.tan(base),
    separation: length + gap * pitch,
    reach: height * Math.min(aspect, 2 - aspect),  // the farthest that light is displaced across the ridges
  };
}

// A face of lenses that bulge to smaller z (side -1) or to greater z (1), up to z = `vertex`: u and z of an edge's start, u and z
// of its end, its radius.
function lenses(vertex, focal, index, side) {
  const radius = focal * (index - 1) / index, corner = vertex - side * (radius - Math.sqrt(radius * radius - 0.25));
  return side < 0 ? [0, corner, 1, corner, radius] : [1, corner, 0, corner, radius];
}

// The edges of a Dove prism: base, near facet, top, far facet.
function dove(values) {
  const { pitch, height, length } = prism(values), { gap, base_angle } = values;
  const [low, high, base] = [gap / 2, 1 - gap / 2, length / pitch / 2], top = base - height / pitch / Math.tan(radians(base_angle));
  return [[low, base, low, -base, 0], [low, -base, high, -top, 0], [high, -top, high, top, 0], [high, top, low, base, 0]];
}

// The cross-section of the sheets in a window, in pitches, and their number across the window; null for Dove prisms.
// povgen/optics/profile.py. That of the kind "profile" is made in Python (povgen/liveview/values.py).
function profile({ sheet, values }) {
  if (sheet === "profile") return { ...values.profile, count: values.periods };
  if (sheet !== "lenticular") return null;
  const { index, design_index = index, gap, ratio, f_number, lenses: count } = values, half = (1 + ratio) * f_number / 2;
  const edges = [lenses(-half, f_number, design_index, -1), lenses(half, ratio * f_number, design_index, 1)];
  return { edges, half, index, gap, count };
}

// The shape of the prisms or lenses in a window. Prisms have no `edges`.
export function shape(window) {
  const made = profile(window);
  if (!made) return { ...prism(window.values), edges: [] };
  const pitch = window.values.aperture / made.count, length = 2 * made.half * pitch;
  return { pitch, length, separation: length + made.gap * pitch, index: made.index, edges: made.edges };
}

// The same for the ray trace in a page, in pitches: Dove prisms have edges, too. `path` has the numbers of those that light on the
// designed path meets on its way to greater z.
export function outlines(window) {
  const { pitch, length, index, edges } = shape(window);
  return { pitch, half: length / pitch / 2, index, ...(edges.length ? { edges, path: [1, 2] } : { edges: dove(window.values), path: [2, 1, 4] }) };
}

const isSingle = ({ sheet, values }) => sheet === "single" || (sheet === "profile" && values.arrangement === "single");

// The sheets of prisms or lenses in a window, those near the eye first: the angle about z, radians, z of the middle plane, from
// the middle of the window, and the thickness. povgen/optics/trace.py
export function sheets(window) {
  if (!hasPrisms(window)) return [];
  const { separation, length } = shape(window), aside = separation / 2;
  if (isSingle(window)) return [{ angle: 0, centre: 0, length }];
  return [{ angle: radians(window.values.alpha) / 2, centre: -aside, length }, { angle: 0, centre: aside, length }];
}

// Extent of a window's sheets along z.
export const thickness = (window) => sheets(window).reduce((extent, { centre, length }) => Math.max(extent, 2 * centre + length), 0);
