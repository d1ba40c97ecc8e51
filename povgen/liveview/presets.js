// What a scene shows, as the shaders draw it: its eye, windows, objects and floor, in tiles. A room's are in its values
// (povgen/liveview/values.py). A preset's follow from its parameters, as in povgen/scene/presets.py.

import { radians, shape, thickness } from "./geometry.js";
import { hasPrisms } from "./sheets.js";

const AXES = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

// What is particular to each preset: z1 of each object that a prediction is for, the floor's height, all objects, and whether
// predictions are for a piece, which stands on a pedestal on the floor.
const PRESETS = {
  chess: {
    hasPiece: true,
    z1: ({ z1 }) => [z1].flat(),
    floorY: (scene) => (scene.floor === "none" ? null : frameFoot(scene)),
    objects(scene, names) {
      const [pieces, x, z1, colours] = listed([scene.piece, scene.x, scene.z1, scene.color].map((values) => [values].flat()));
      const y = frameFoot(scene), last = lastZ(scene), { pedestal } = scene;
      const pedestals = pieces.map((name, k) => upright("pedestal", [x[k], y, last + z1[k]], [scene.pedestal_halves[name], pedestal, 0, 0]));
      return [
        ...pieces.map((name, k) => upright("piece", [x[k], y + pedestal, last + z1[k]], [names.indexOf(name), 0, 0, 0], colours[k])),
        ...(pedestal ? pedestals : []),
      ];
    },
  },
  spheres: {
    z1: row,
    floorY: () => null,
    objects: (scene) => row(scene).map((z1, k, { length }) =>
      upright("sphere", [...scene.line, lastZ(scene) + z1], [radius(z1, scene.z2), k / length, 0, 0])),
  },
};

// A scene for measuring has no objects.
const preset = ({ name }) => PRESETS[name] ?? { floorY: () => null, objects: () => [] };

const upright = (kind, place, numbers, colour = [0, 0, 0]) => ({ kind, place, axes: AXES, numbers, colour });

// ---- Any scene ----

/** The windows, with what `windows` says of each: place, axes, half the width and height, outline and frame. A preset's are on the
 * z axis.
 * @returns {any[]} */
export function openings(scene) {
  if (scene.windows) return scene.windows;
  const shared = { axes: AXES, half: [scene.aperture / 2, scene.aperture / 2], round: false, depth: depth(scene), framed: true };
  return windows(scene).map((window) => ({ ...window, ...shared, place: [0, 0, window.z] }));
}

/** The objects but for the floor. `names` are those of the distance fields of pieces.
 * @returns {any[]} */
export const objects = (scene, names) => scene.objects ?? preset(scene).objects(scene, names);

// Height of the floor; null: there is none.
export const floorY = (scene) => (scene.objects ? scene.floor_y : preset(scene).floorY(scene));

// The eye, and the rectangle that the picture shows: its middle, unit vectors along its sides, its height. A room's eye looks at
// the middle: `Eye.camera` in povgen/scene/room.py. A headset's eyes have a camera of their own.
export function camera(scene) {
  if (scene.camera) return scene.camera;
  const [right, up, along] = AXES;
  if (!scene.objects) return { eye: [...scene.eye, -scene.z2], middle: [...scene.look, 0], right, up, height: scene.view };
  const { x, y, z, look_x, look_y, look_z, roll, view } = scene.eye, place = [x, y, z], middle = [look_x, look_y, look_z];
  const ahead = unit(along.map((_, k) => middle[k] - place[k]));
  const across = Math.hypot(ahead[0], ahead[2]) > 1e-9 ? unit(cross(up, ahead)) : right, above = cross(ahead, across);
  const [c, s] = [Math.cos(radians(roll)), Math.sin(radians(roll))];
  const sides = [along.map((_, k) => c * across[k] + s * above[k]), along.map((_, k) => c * above[k] - s * across[k])];
  return { eye: place.map((each, k) => each + scene.eye.aside * sides[0][k] + scene.eye.above * sides[1][k]), middle, right: sides[0], up: sides[1], height: view };
}
/** @type {(one: number[], other: number[]) => number[]} */
export const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
const unit = (v) => v.map((x) => x / Math.hypot(...v));

// A room's eye after a step along its picture's right and upper side, tiles. It still looks at the middle.
export function steppedEye(scene, [x, y]) {
  const { right, up } = camera(scene);
  return { ...scene.eye, ...Object.fromEntries(["x", "y", "z"].map((name, k) => [name, scene.eye[name] + x * right[k] + y * up[k]])) };
}

// A window that a slider can turn says so: then the shader is the same before and after.
export const isTurned = ({ axes, turned = false }) => turned || String(axes) !== String(AXES);

// How far away a floor ends: POV-Ray does not show what is farther away.
export const horizon = (scene) => 1e7 / tile(openings(scene));

// ---- Presets ----

/** The windows, the nearest to the eye first: the kind of their sheets, z, and the values of all parameters.
 * What a window does not state is that of the first one.
 * @returns {any[]} */
export function windows(scene) {
  const further = scene.window.map((window) => {
    const given = Object.fromEntries(Object.entries(window).filter(([, value]) => value !== null));
    return { ...scene, ...given };
  });
  return [{ ...scene, z: 0 }, ...further].map((values) => ({ sheet: values.sheet, z: values.z, values }));
}

// Extent of a window frame along z.
export const depth = (scene) => Math.max(scene.aperture / 10, ...windows(scene).map((window) => 1.02 * thickness(window)));

// Height of a picture of 4:3 that shows the first window's whole frame, at most twice the usual one: `default_view` in
// povgen/scene/eye_and_windows.py.
export function wholeView({ aperture, rim, eye: [x, y], z2, view }, deep) {
  const slant = Math.min(rim, deep);
  const reaches = [[0.6, 0], [0.75, 0.25], [1, 0.5]].map(([out, part]) => {
    const scale = z2 / (z2 - deep / 2 + part * slant), half = scale * (aperture / 2 + out * rim);
    return Math.max(half + (scale - 1) * Math.abs(y), (half + (scale - 1) * Math.abs(x)) * 0.75);
  });
  return Math.max(view, Math.min(2 * view, 2.06 * Math.max(...reaches)));  // without a jump while z2 changes
}

/** Whether the object of a preset, by the preset's name, is a piece on a pedestal.
 * @returns {boolean} */
export const hasPiece = (name) => Boolean(PRESETS[name].hasPiece);

// z1 of every object.
export const distances = (scene) => PRESETS[scene.name].z1(scene);

// z of the last window, from which the objects' z1 counts.
const lastZ = (scene) => windows(scene).at(-1).z;

// Height of what the window's frame stands on.
export const frameFoot = (scene) => -(scene.aperture / 2 + scene.rim);

// POV-Ray's units per tile. povgen/limits.py
const tile = (all) => Math.max(1000, ...all.filter(hasPrisms).map((window) => Math.round(1.2 / shape(window).pitch)));

// Lists with a value for each object, from lists of which some have one value for all.
function listed(lists) {
  const count = Math.max(...lists.map((list) => list.length));
  return lists.map((list) => (list.length === 1 ? Array(count).fill(list[0]) : list));
}

// The radius of a sphere.
export const radius = (z1, z2) => Math.min(0.085 * (z1 / z2) ** 0.1 * (1 + z1 / z2), z1 / 6);

// z1 of every sphere: if none is given, 2^n z2.
function row(scene) {
  if (scene.z1) return [scene.z1].flat();
  const most = 5e6 / tile(windows(scene)) - lastZ(scene), back = depth(scene) / 2;
  let nearest = back;
  for (let n = 0; n < 30; n++) nearest = back + radius(nearest, scene.z2);
  return Array.from({ length: 11 }, (_, n) => 2 ** (n - 5) * scene.z2).filter((z1) => z1 > nearest && z1 <= most);
}
