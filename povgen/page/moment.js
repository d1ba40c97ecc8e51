// The numbers that follow from what the user has set (state.js): positions, angles, magnifications. Lengths are in tiles,
// points are [x, y] as the eye sees them.

import * as geometry from "../liveview/geometry.js";
import { depth, distances, hasPiece, radius, wholeView, windows } from "../liveview/presets.js";
import { hasPrisms } from "../liveview/sheets.js";
import { crossing, crossings, following, landing, meets, pole } from "./apparent.js";
import { abs, arg, determinant, dot, finite, minus, plus, resolved, scaled, times, turn } from "./complex.js";
import { clamped, data, pick } from "./data.js";
import * as equations from "./equations.js";
import { outlineOf, within } from "./outline.js";
import { FLOOR, inSeries, isGeneral, session, state } from "./state.js";

// The least z2. `back` is half the depth of the window frame. The eye is just in front of it, or farther away if the frame is
// deep, so that it sees through.
const leastZ2 = (back) => back * (1 + 3 * clamped((back - 1) / 3, [0, 1])) + 0.011;

// The scene with other sheets: those to the right of the curtain, if no others are given. There is no second window.
const compared = (scene, sheet = state.compare) => ({ ...scene, sheet, window: [] });
// There the objects are where they are.
/** @type {(now: any, sheet?: string) => any} */
export const otherScene = ({ scene, objects, d }, sheet) => ({ ...compared(scene, sheet), z1: d ? objects.map((z1) => z1 + d) : scene.z1 });

// The depth of the window's frame, on the side of the curtain where it is deeper.
export const frameDepth = (scene) => Math.max(depth(scene), depth(compared(scene)));

// The distance of two eyes, tiles, if a tile is some 20 cm: with a larger one, glasses show the mountains twice.
export const EYES = 0.3;

// The values of povgen's scene, for the live view. z1 and z2 are made large enough to keep object and eye out of the frame.
export function sceneValues() {
  const { scene, piece, L, E, sheet2, alpha2, d } = state;
  const values = { ...data.scenes[scene], ...pick(state, "sheet", "prisms", "pupil", "focus", ...Object.keys(data.parameters)), eye: E, eyes: state.depth ? EYES : 0, faces: data.faces };
  if (!session.floor) values.floor = "none";
  if (inSeries()) {
    values.window = [{ alpha: alpha2, z: d, sheet: sheet2 === "same" ? null : sheet2 }];
    values.window[0].z = Math.max(d, depth(values) + 0.011);
  }
  const back = frameDepth(values) / 2;
  values.z2 = Math.max(state.z2, leastZ2(back));
  values.view = wholeView(values, 2 * back);
  if (!hasPiece(scene)) return { ...values, line: L };
  const foot = data.pedestals[piece];
  const z1 = Math.max(state.z1, back + foot + 0.001);
  return { ...values, piece, pedestal_halves: data.pedestals, z1, x: L[0], pedestal: L[1] - FLOOR };
}

// All numbers that the page shows. Angles are in radians, except `degrees`.
export function moment() {
  const scene = sceneValues();
  const { z2, alpha: degrees, sheet } = scene;
  const objects = distances(scene);
  const z1 = objects.reduce((best, z) => (Math.abs(Math.log(z / state.z1)) < Math.abs(Math.log(best / state.z1)) ? z : best));
  const alpha = sheet === "none" ? 0 : geometry.radians(degrees);
  const r = z2 / z1;
  /** @type {any} */
  const now = { scene, sheet, degrees, alpha, z1, z2, r, objects, L: state.L, E: state.E, prism: geometry.prism(scene) };
  now.radii = hasPiece(state.scene) ? [data.feet[state.piece]] : objects.map((each) => radius(each, z2));
  now.windows = windows(scene);
  now.lenses = sheet === "lenticular";
  now.glass = !now.lenses && now.windows.some(hasPrisms);
  now.prisms = now.windows.map((window) => (now.glass && hasPrisms(window) ? geometry.prism(window.values) : {}));
  now.follow = following(now.windows, state.E, z2);
  now.general = isGeneral();  // whether `apparent.js` follows rays, because the equations are for windows that rotate light
  // the distance from the first window to the second, and its angle: as `behind` in equations.js
  now.behind = now.windows.slice(1).map(({ z, sheet, values }) => [z, sheet === "none" ? 0 : geometry.radians(values.alpha)]);
  now.d = now.behind[0]?.[0];
  if (now.d && !now.general) {
    now.Z = equations.depth(z1, z2, alpha, now.behind);
    now.total = alpha + now.behind[0][1];
  }
  // the paper's window; or a choice beyond the paper
  now.two = (sheet === "ideal" || sheet === "detailed") && !now.d && !now.general;
  now.beyond = Boolean(now.d || now.general);
  now.P = equations.P(r, alpha);
  now.place = markedPosition(now);
  Object.assign(now, appearance(now), focusing(now));
  scene.inverse_focus = 1 / now.focus;
  // whether the line of sight to L through the first window misses the second one
  now.beside = !(now.M > NEAR_POLE) && !outside(now.place, scene) && isBesideSecond(now, now.place);
  // Near the pole, where M is infinite, the window shows a small part of the object's plane: its width is `seen`.
  now.nearPole = now.M > NEAR_POLE && (now.two || now.Z || Number.isFinite(now.turned) || now.M === Infinity);
  now.seen = scene.aperture / now.M;
  return now;
}
export const NEAR_POLE = 12;  // a larger M is near the pole

// The point of the plane z = 0 at which the sheets show a point, by default L. Through a sheet beyond the paper, light that
// passes L at a distance of up to `near` counts too.
export function apparentPosition(now, L = now.L, { z1, z2, alpha } = now, near = 0) {
  const { E, prism, prisms, behind } = now;
  if (imagingPole(now, z1, z2)) return [Infinity, 0];
  if (now.general) return crossing(L, E, z1, z2, now.windows, near);
  if (now.sheet === "single") return equations.mirrored(L, E, z1, z2, prism);
  return equations.position(L, E, z1, z2, alpha, prisms, behind);
}

// The same for the points of an outline.
export function apparentOutline(now, points) {
  if (now.general && !imagingPole(now, now.z1, now.z2)) return crossings(points, now.E, now.z1, now.z2, now.windows);
  return points.map((point) => apparentPosition(now, point));
}

// Where an object is marked: where its middle is seen, or a place close to it if only a part beside the middle is seen.
export const markedPosition = (now) => apparentPosition(now, now.L, now, now.radii[now.objects.indexOf(now.z1)]);

// The angle nu by which an object appears rotated, and its magnification M. A single sheet mirrors: nu is NaN, M
// is the magnification of the width, and `height` that of the height. For sheets beyond the paper, nu is NaN, and M is the
// square root of the area's magnification. `turned` is their angle of rotation, or NaN if the object appears distorted.
export function appearance(now) {
  const { sheet, z1, z2, alpha, prism, prisms, behind } = now;
  if (imagingPole(now, z1, z2)) return { nu: NaN, M: Infinity };
  if (now.general) {
    const [right, up] = shownSteps(now);
    const same = (now.lenses ? 0.2 : 1e-6) * abs(right);  // sheets of lenses distort a little, as those of prisms do
    const whole = plus(right, times([0, -1], up));
    return { nu: NaN, M: Math.sqrt(Math.abs(determinant([right, up]))), turned: abs(minus(up, times([0, 1], right))) < same ? arg(whole) : NaN };
  }
  if (sheet === "single") return { nu: NaN, M: z2 / (z1 + z2 - prism.slab_shift), height: Math.abs(z2 / (z2 - z1)) };
  return equations.turned(z1, z2, alpha, prisms, behind);
}

// The columns of the Jacobian d(apparent position)/d(L), by central differences.
const shownSteps = (now) => [[1e-3, 0], [0, 1e-3]].map((h) => scaled(500, minus(apparentPosition(now, plus(now.L, h)), apparentPosition(now, minus(now.L, h)))));

// How an eye with a pupil sees the object: povgen/scene/pupil.py. The slope of the object's light changes with the place where it
// enters the pupil, as a linear map with the other sign, 1/tile. For light of a point at the distance f this map is 1/f times the
// identity. `light` has the columns of the first map, and `same` those of the identity, as angles in place of slopes. `best` is 1 /
// the distance that blurs the object least: NaN if it has no image, then the focus is in the window.
function focusing({ windows, E, place, z1, z2 }) {
  const slope = scaled(1 / z2, minus(place, E)), r = Math.hypot(1, ...slope);
  const angle = (step) => scaled(1 / r, minus(step, scaled(dot(slope, step) / (r * (1 + r)), slope)));
  const end = (aside, s) => landing(following(windows, plus(E, aside), z2)(plus(slope, s)), windows, z1) ?? [NaN, NaN];
  const columns = (ends) => [[STEP, 0], [0, STEP]].map((h) => scaled(0.5 / STEP, minus(ends(h), ends(scaled(-1, h)))));
  const bySlope = columns((h) => end([0, 0], h));
  const light = columns((h) => end(h, [0, 0])).map((column) => angle(resolved(column, bySlope))), same = [[1, 0], [0, 1]].map(angle);
  const summed = (columns) => dot(columns[0], same[0]) + dot(columns[1], same[1]);
  const best = light.every(finite) ? Math.max(0, summed(light) / summed(same)) : NaN;
  return { light, same, best, focus: state.focus === "best" ? 1 / (Number.isNaN(best) ? 1 / z2 : best) : state.focus };
}

// The RMS angle by which the pupil blurs each point of the object, if the eye is focused at the distance 1/near, radians.
export const pupilBlur = ({ scene, light, same }, near) =>
  (scene.pupil / 4) * Math.hypot(...light.flatMap((column, k) => minus(column, scaled(near, same[k]))));

// How the object must move, in tiles, to appear to move by `step`.
export function objectStep(now, step) {
  const steps = shownSteps(now);
  const area = determinant(steps);
  if (!Number.isFinite(area) || Math.abs(area) > 50 || Math.abs(area) < 1e-6) return step;
  return resolved(step, steps);
}

// Whether the prediction can be wrong by more than povgen/limits.py allows.
export function unsure(now) {
  if (now.lenses) return true;
  if (now.glass) return !(possibleError(now) <= data.limits.error);
  return !now.general && now.M > data.limits.condition;
}

// By how many pixels of 1280x960 the prediction can be wrong, for windows of which some have prisms: povgen/scene/warnings.py and
// povgen/optics/uncertainty.py.
export function possibleError(now) {
  const { scene, E, z1, z2, windows, place, radii, objects } = now;
  const slope = scaled(1 / z2, minus(place, E));
  // the derivatives by the slope at the eye: of a complex number f of a ray's path, to the right and up
  const steps = [[STEP, 0], [-STEP, 0], [0, STEP], [0, -STEP]];
  const [path, ...paths] = [[0, 0], ...steps].map((step) => now.follow(plus(slope, step)));
  const derivative = (f) => [0, 2].map((k) => scaled(0.5 / STEP, minus(f(paths[k]), f(paths[k + 1]))));
  if (paths.some((each) => !landing(each, windows, z1))) return Infinity;
  const [right, up] = derivative((each) => landing(each, windows, z1));
  const [a, b] = [1, -1].map((sign) => abs(plus(right, times([0, -sign], up))) / 2);
  const sizes = [a + b, Math.abs(a - b)];  // the singular values of the map a s + b conj(s)
  if (!(sizes[1] > 1e-9 * z2)) return Infinity;
  const scale = z2 / sizes[1];
  const [least, most] = data.limits.radii;
  const apparent = clamped(((z2 / sizes[0] + scale) / 2) * radii[objects.indexOf(z1)], [least, most]);
  // the sheets of prisms: `Layer` in uncertainty.py
  const glass = path.flatMap(({ sheet }, n) => {
    if (!sheet?.prism) return [];
    const { angle, prism, number } = sheet;
    const [x, y] = derivative((each) => each[n].place).map((step) => times(step, turn(-angle))[1] / (z2 * prism.pitch));
    return [{ k: [y, x], prism, tangent: abs(meets(path, number).slope) }];
  });
  const share = (frequency, periods) => Math.min(1, (periods / (abs(frequency) * apparent)) ** 4);
  const spreads = glass.map(({ prism }) => scale * prism.reach);
  const shares = glass.map(({ k }, n) => {
    const pairs = glass.filter((_, m) => m !== n).flatMap((other) => [plus(k, other.k), minus(k, other.k)]);
    return spreads[n] * Math.max(share(k, 1), ...pairs.map((pair) => share(pair, 0.6)));
  });
  const sum = (numbers) => numbers.reduce((total, x) => total + x, 0);
  const beyond = sum(glass.map(({ prism: { slab_shift, index }, tangent }) => (slab_shift * tangent ** 3 * (index + 1)) / (2 * index ** 2)));
  const error = Math.max(2 * Math.max(...shares), sum(shares)) + scale * beyond + Math.max(...spreads) ** 2 / (0.15 * z2);
  return (error / scene.view) * 960;
}
const STEP = 1e-6;  // of the slopes of neighbouring rays

// Whether the line of sight through a place in the plane of the first window passes beside the second one.
function isBesideSecond(now, place) {
  const at = atSecondWindow(now, place);
  return Boolean(at) && outside(at, now.scene);
}

// Where this line of sight crosses the second window; undefined if there is none, or if no light passes.
const atSecondWindow = ({ follow, E, z2 }, place) => meets(follow(scaled(1 / z2, minus(place, E))), 1)?.place;

export const outside = (point, scene) => point.some((x) => Math.abs(x) > scene.aperture / 2);

// At their pole, sheets with linear laws show only a "point" or a "line" of the object's plane. Otherwise "".
export const imagingPole = (now, z1, z2) => (now.general ? pole(now.windows, now.E, z1, z2) : "");

// ---- What is in the window: what the lines of sight through it meet ----

// The line of sight through a place of the plane z = 0, behind the last window: its slope, and where it crosses the plane at
// the distance z1. `beside` if it misses the second window. null if no light passes.
function sight(now, place) {
  const { windows, z1 } = now;
  const path = now.follow(scaled(1 / now.z2, minus(place, now.E)));
  if (isBesideSecond(now, place)) return { ...meets(path, 1), point: place, beside: true };
  const point = landing(path, windows, z1);
  return point && { slope: path.at(-1).slope, point };
}

// What a line of sight meets: "thing" (the object at L), or one of the names in SHOWN.
function met(now, line) {
  if (!line) return "dark";
  const { L, objects, z1, radii } = now;
  const { slope, point, beside } = line;
  const [x, y] = minus(point, L);
  if (beside) {
    // seen without the second window: not as the windows show it
  } else if (!hasPiece(state.scene)) {
    if (abs([x, y]) <= radii[objects.indexOf(z1)]) return "thing";
  } else {
    const lines = outlineOf(state.piece);
    if (!lines.length || within([x, y], lines)) return "thing";  // the outline may not be known yet
    const half = data.pedestals[state.piece];
    const crosses = ([x, y]) => Math.abs(x) <= half && y <= 0 && y >= FLOOR - L[1];
    if ([-half, 0, half].some((z) => crosses(plus([x, y], scaled(z, slope))))) return "pedestal";
  }
  if (slope[1] < 0) return hasPiece(state.scene) ? "floor" : "ground";
  return slope[1] < MOUNTAINS ? "mountains" : "sky";
}

const MOUNTAINS = 0.05;  // slope: most mountains are higher
// in the order in which they are said
export const SHOWN = ["pedestal", "others", "floor", "ground", "mountains", "sky", "dark"];
const PLACES = [-0.98, -0.8, -0.6, -0.4, -0.2, 0, 0.2, 0.4, 0.6, 0.8, 0.98];  // of half the window

// What the eye sees through a place of the window.
export const seenAt = (now, place) => met(now, sight(now, place));

// The names of what the window shows: of what it shows at a grid of places, and of small objects.
export const contents = (now) => (now.contents ??= foundInWindow(now));

function foundInWindow(now) {
  const half = now.scene.aperture / 2;
  /** @type {Set<string>} */
  const found = new Set(PLACES.flatMap((x) => PLACES.map((y) => met(now, sight(now, [x * half, y * half])))));
  const outline = () => apparentOutline(now, outlinePoints(now).map((d) => plus(now.L, d)));
  if (!found.has("thing") && outline().some((place) => isInWindow(now, place))) found.add("thing");
  const seen = (z1) => isInWindow({ ...now, z1 }, apparentPosition(now, now.L, { ...now, z1 }));
  if (now.objects.some((z1) => z1 !== now.z1 && seen(z1))) found.add("others");
  return found;
}

const isInWindow = (now, place) =>
  finite(place) && !outside(place, now.scene) && !isBesideSecond(now, place);

// Points of the object's outline, from L.
function outlinePoints({ objects, z1, radii }) {
  if (hasPiece(state.scene)) return outlineOf(state.piece).flatMap((line) => line.filter((_, n) => n % 4 === 0));
  return [[0, 0], ...Array.from({ length: 12 }, (_, k) => scaled(radii[objects.indexOf(z1)], turn((k * Math.PI) / 6)))];
}
