// The numbers that follow from the state. Lengths are in tiles, points are [x, y] as the eye sees them.

import * as geometry from "../live/geometry.js";
import { bending, windows } from "../live/sheets.js";
import { crossing, pole } from "./aim.js";
import { behindFirst, inSeries } from "./beyond.js";
import { abs, arg, determinant, minus, plus, resolved, scaled, times } from "./complex.js";
import { clamped, data, pick } from "./data.js";
import * as equations from "./equations.js";
import { FLOOR, state } from "./state.js";

// The least distance of the eye: just in front of the window frame, or far enough to see through a deep one.
const leastZ2 = (back) => back * (1 + 3 * clamped((back - 1) / 3, [0, 1])) + 0.011;

// The values of povgen's scene, for the live view. z1 and z2 are large enough for the sheets' depth.
export function sceneValues() {
  const { scene, piece, L, E, alpha2, d } = state;
  const values = { ...data.scenes[scene], ...pick(state, "sheet", "prisms", ...Object.keys(data.parameters)), eye: E, faces: data.faces };
  if (inSeries()) values.window = [{ alpha: alpha2, z: Math.max(d, geometry.depth(values) + 0.011), sheet: null }];
  const back = geometry.depth(values) / 2;
  values.z2 = Math.max(state.z2, leastZ2(back));
  if (scene === "spheres") return { ...values, line: L };
  const foot = data.pedestals[piece];
  const z1 = Math.max(state.z1, back + foot + 0.001);
  return { ...values, piece, pedestal_halves: data.pedestals, z1, x: L[0], pedestal: L[1] - FLOOR };
}

// All numbers that the page shows. Angles are in radians, but `degrees`.
export function moment() {
  const scene = sceneValues();
  const { z2, alpha: degrees, sheet } = scene;
  const objects = geometry.distances(scene);
  const z1 = objects.reduce((best, z) => (Math.abs(Math.log(z / state.z1)) < Math.abs(Math.log(best / state.z1)) ? z : best));
  const alpha = sheet === "none" ? 0 : geometry.radians(degrees);
  const r = z2 / z1;
  /** @type {any} */
  const now = { scene, sheet, degrees, alpha, z1, z2, r, objects, L: state.L, E: state.E, prism: geometry.prism(scene) };
  now.radii = state.scene === "spheres" ? geometry.spheres(scene).map(({ radius }) => radius) : [data.feet[state.piece]];
  [now.window] = windows(scene);
  now.kind = data.kinds[sheet];  // of the sheets beyond the paper's
  if (now.kind) now.bend = bending(now.window);
  now.behind = behindFirst(scene);
  if (now.behind.length) {
    [[now.d]] = now.behind;
    now.Z = equations.depth(z1, z2, alpha, now.behind);
    now.total = alpha + now.behind[0][1];
  }
  // the paper's window; or a choice beyond the paper
  now.two = (sheet === "ideal" || sheet === "detailed") && !now.Z;
  now.beyond = Boolean(now.Z || now.kind);
  now.P = equations.P(r, alpha);
  now.place = markedPosition(now);
  Object.assign(now, appearance(now));
  // whether the line of sight to L through the first window misses the second one
  now.beside = Boolean(now.Z) && now.M <= NEAR_POLE && !outside(now.place, scene) && outside(equations.atSecondWindow(now), scene);
  // near the pole, the window shows a small part of the object's plane: its width
  now.nearPole = now.M > NEAR_POLE && (now.two || Boolean(now.Z) || Number.isFinite(now.turned) || now.M === Infinity);
  now.seen = scene.aperture / now.M;
  return now;
}
export const NEAR_POLE = 12;  // a larger M is near the pole

// The point of the plane z = 0 at which the sheets show a point, by default L.
// Through the other sheets, light that passes the point at a distance of up to `near` counts too.
export function apparentPosition(now, L = now.L, { z1, z2, alpha } = now, near = 0) {
  const { E, prism, behind } = now;
  if (imagingPole(now, z1, z2)) return [Infinity, 0];
  if (now.kind) return crossing(L, E, z1, z2, now.window, near);
  if (now.sheet === "single") return equations.mirrored(L, E, z1, z2, prism);
  if (now.sheet === "detailed") return equations.prisms(L, E, z1, z2, alpha, prism, behind);
  return equations.ideal(L, E, z1, z2, alpha, behind);
}

// Where an object is marked: where its middle is seen, or a place close to it if only a part beside the middle is seen.
export const markedPosition = (now) => apparentPosition(now, now.L, now, now.radii[now.objects.indexOf(now.z1)]);

// The angle nu by which an object appears rotated, and its magnification M. A single sheet mirrors: nu is NaN, and M is that
// of the width; `height` is that of the height. For the other sheets, M is the square root of the area's magnification;
// `turned` is the angle if the object appears undistorted.
export function appearance(now) {
  const { sheet, z1, z2, alpha, prism, behind } = now;
  if (imagingPole(now, z1, z2)) return { nu: NaN, M: Infinity };
  if (now.kind) {
    const [right, up] = shownSteps(now);
    return { nu: NaN, M: Math.sqrt(Math.abs(determinant([right, up]))), turned: abs(minus(up, times([0, 1], right))) < 1e-6 * abs(right) ? arg(right) : NaN };
  }
  if (sheet === "single") return { nu: NaN, M: z2 / (z1 + z2 - prism.slab_shift), height: Math.abs(z2 / (z2 - z1)) };
  if (sheet === "detailed") return equations.turned(z1, z2, alpha, prism, behind);
  if (behind.length) {
    const Z = equations.depth(z1, z2, alpha, behind);
    return { nu: abs(Z) === 0 ? NaN : -arg(Z), M: z2 / abs(Z) };
  }
  return { nu: equations.nu(z2 / z1, alpha), M: equations.M(z2 / z1, alpha) };
}

// The columns of the Jacobian d(apparent position)/d(L), by central differences.
const shownSteps = (now) => [[1e-3, 0], [0, 1e-3]].map((h) => scaled(500, minus(apparentPosition(now, plus(now.L, h)), apparentPosition(now, minus(now.L, h)))));

// Where the object must be moved to appear moved by a step, tiles: the inverse of the linear map of `apparentPosition`.
export function objectStep(now, step) {
  const steps = shownSteps(now);
  const area = determinant(steps);
  if (!Number.isFinite(area) || Math.abs(area) > 50 || Math.abs(area) < 1e-6) return step;
  return resolved(step, steps);
}

// Whether the prediction can be wrong by pixels. The limits are in povgen/limits.py.
export function unsure(now) {
  if (now.sheet === "none" || now.kind) return false;
  if (now.sheet === "ideal") return now.M > data.limits.condition;
  return !(possibleError(now) <= data.limits.error);
}

// By how many pixels of 1280x960 the prediction can be wrong, for one sheet or windows of prisms: povgen/scene/warnings.py.
export function possibleError(now) {
  const { sheet, scene, E, z1, z2, alpha, behind, prism, place, radii, objects } = now;
  const { M, height } = appearance(now);
  const single = sheet === "single";
  const k = single ? [[1 / prism.pitch, 0]] : equations.frequencies(z2, alpha, prism, behind);
  const { A, B } = equations.depths(z1, z2, alpha, prism, behind);
  const scale = z2 / Math.abs(single ? z2 - z1 : abs(A) - abs(B));
  if (!Number.isFinite(scale)) return Infinity;
  const [least, most] = data.limits.radii;
  const apparent = Math.min(Math.max((single ? height : M) * radii[objects.indexOf(z1)], least), most);
  return (equations.possibleError(k, scale, apparent, abs(minus(place, E)) / z2, z2, prism, scene.index) / scene.view) * 960;
}

export const outside = (point, scene) => point.some((x) => Math.abs(x) > scene.aperture / 2);

// What a sheet with a linear law shows of the object's plane at its pole: a "point" or a "line". Otherwise "".
export const imagingPole = (now, z1, z2) => (now.bend ? pole(now.window, now.E, z1, z2) : "");
