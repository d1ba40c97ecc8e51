// What follows from a scene's values, as in povgen/optics/prism.py and povgen/scene/models.py. Lengths are in tiles,
// angles in degrees.

import { hasPrisms, windows } from "./sheets.js";

export const radians = (degrees) => degrees * (Math.PI / 180);

// The shape of the prisms: povgen/optics/prism.py.
export function prism(scene) {
  const pitch = scene.aperture / scene.prisms;
  const base = radians(scene.base_angle);
  const slope = Math.PI / 2 - base - Math.asin(Math.cos(base) / scene.index);
  const height = pitch * (1 - scene.gap);
  const length = height * scene.aspect * (1 / Math.tan(base) + 1 / Math.tan(slope));
  return {
    pitch, height, length,
    slab_shift: height * scene.aspect * Math.tan(base),
    separation: length + scene.gap * pitch,
    reach: height * Math.min(scene.aspect, 2 - scene.aspect),  // the farthest that light is displaced across the ridges
  };
}

// The sheets of prisms in a window, those near the eye first: the angle about z, radians, and z of the middle plane, from
// the middle of the window. povgen/optics/trace.py
export function sheets(scene, window) {
  if (!hasPrisms(window)) return [];
  const aside = prism(scene).separation / 2;
  if (window.sheet === "single") return [{ angle: 0, centre: 0 }];
  return [{ angle: radians(window.values.alpha) / 2, centre: -aside }, { angle: 0, centre: aside }];
}

// Extent of a window frame along z.
export function depth(scene) {
  const { length, separation } = prism(scene);
  const thickness = { detailed: length + separation, single: length };
  return Math.max(scene.aperture / 10, ...windows(scene).map(({ sheet }) => 1.02 * (thickness[sheet] ?? 0)));
}

// z of the last window, from which the objects' z1 counts.
export const lastZ = (scene) => windows(scene).at(-1).z;

// The window frame's cross-section, from the opening's front to its back: distance from the opening, and z. The lip's
// width. templates/frame.pov.j2
export function frameSection(scene) {
  const half = depth(scene) / 2, { rim } = scene, slant = Math.min(rim, 2 * half);
  return [
    [0, -half], [0.6 * rim, -half], [0.75 * rim, 0.25 * slant - half], [rim, 0.5 * slant - half], [rim, half], [0, half],
  ];
}

export const frameLip = (scene) => 0.2 * scene.rim;

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
  return Math.max(1000, windows(scene).some(hasPrisms) ? Math.round(1.2 / prism(scene).pitch) : 0);
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

