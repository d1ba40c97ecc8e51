// What follows from a scene's values, as in povgen/optics/prism.py and povgen/scene/scenes.py. Lengths are in tiles,
// angles in degrees.

import { hasPrisms, windows } from "./sheets.js";

export const radians = (degrees) => degrees * (Math.PI / 180);

// The shape of the prisms with these values of a scene or a window: povgen/optics/prism.py.
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

// Extent of a window frame along z.
export function depth(scene) {
  const thickness = windows(scene).filter(hasPrisms).map((window) => {
    const { length, separation } = shape(window);
    return isSingle(window) ? length : length + separation;
  });
  return Math.max(scene.aperture / 10, ...thickness.map((extent) => 1.02 * extent));
}

// z of the last window, from which the objects' z1 counts.
const lastZ = (scene) => windows(scene).at(-1).z;

export const floorY = (scene) => -(scene.aperture / 2 + scene.rim);

// Lists with a value for each object, from lists of which some have one value for all.
function listed(lists) {
  const count = Math.max(...lists.map((list) => list.length));
  return lists.map((list) => (list.length === 1 ? Array(count).fill(list[0]) : list));
}

// The pieces: name of the distance field, centre of the foot, colour (sRGB, 0 to 1), half the pedestal's width.
export function pieces(scene) {
  if (scene.name !== "chess") return [];
  const [piece, x, z1, color] = listed([scene.piece, scene.x, scene.z1, scene.color].map((values) => [values].flat()));
  const y = floorY(scene) + scene.pedestal;
  return piece.map((name, k) => ({ name, foot: [x[k], y, lastZ(scene) + z1[k]], color: color[k], half: scene.pedestal_halves[name] }));
}

const radius = (z1, z2) => Math.min(0.085 * (z1 / z2) ** 0.1 * (1 + z1 / z2), z1 / 6);

// POV-Ray's units per tile. povgen/limits.py
export function tile(scene) {
  return Math.max(1000, ...windows(scene).filter(hasPrisms).map((window) => Math.round(1.2 / shape(window).pitch)));
}

export const horizon = (scene) => 1e7 / tile(scene);  // POV-Ray does not show what is farther away

// z1 of every sphere: if none is given, 2^n z2.
export function distances(scene) {
  if (scene.z1) return [scene.z1].flat();
  const most = 5e6 / tile(scene) - lastZ(scene), back = depth(scene) / 2;
  let nearest = back;
  for (let n = 0; n < 30; n++) nearest = back + radius(nearest, scene.z2);
  return Array.from({ length: 11 }, (_, n) => 2 ** (n - 5) * scene.z2).filter((z1) => z1 > nearest && z1 <= most);
}

export function spheres(scene) {
  if (scene.name !== "spheres") return [];
  return distances(scene).map((z1) => ({ centre: [...scene.line, lastZ(scene) + z1], radius: radius(z1, scene.z2) }));
}

