// Rays of light through all windows of the scene, as lines in space: traced through each prism (trace.js), or turned by the
// law of an ideal sheet. Also the field of rays. Points are [x, y, z], in tiles.

import { depth } from "../liveview/presets.js";
import { bending, hasPrisms } from "../liveview/sheets.js";
import { closest } from "./apparent.js";
import { abs, finite, minus, plus, quotient, scaled, times, turn } from "./complex.js";
import { data, pick } from "./data.js";
import * as equations from "./equations.js";
import { state } from "./state.js";
import { passage } from "./trace.js";

/** Follow a ray from a point, in a direction, through all windows. `kind` is "designed", "stray" (has left on the far side, on
 * another path), "back" (has left on the side it came from), "beside" (misses a window), or "lost" (ends on a frame, on black, or
 * nowhere). `points` are the corners of its path, `steps` the faces of prisms that it meets. `frame` is "rim" or "wall" if it ends
 * on a frame, which is a box: on its outside or in its opening.
 * @param {any} now */
export function traced(now, from, towards) {
  const forward = towards[2] > 0, half = now.scene.aperture / 2, outer = half + now.scene.rim, frame = depth(now.scene);
  const ray = { points: [from], steps: [], direction: towards, kind: "designed", frame: "" };
  const lost = (frame = "", way = 0) => ({ ...ray, kind: "lost", frame, points: frame ? [...ray.points, along(ray, way)] : ray.points });
  for (const window of forward ? now.windows : [...now.windows].reverse()) {
    const ends = [window.z - frame / 2, window.z + frame / 2], [meets, leaves] = within(ray, outer, ends), opening = within(ray, half, ends);
    if (!(meets <= leaves)) return { ...ray, kind: "beside" };
    if (meets > 0 && !(opening[0] <= Math.min(opening[1], meets * LARGER))) return lost("rim", meets);
    if (hasPrisms(window)) {
      const { steps, end, designed, direction, place: last } = passage(window, ray.points.at(-1), ray.direction, { frame, most: now.scene.faces });
      ray.steps.push(...steps);
      ray.points.push(...steps.map((step) => step.place), last);
      ray.direction = direction;
      if (end === "frame") {
        const way = within(ray, half, [-Infinity, Infinity])[1], wall = along(ray, way);
        if (way < 0) ray.points.pop();  // at a face behind the wall
        return { ...ray, kind: "lost", frame: "wall", points: [...ray.points, wall] };
      }
      if (end !== "through") return { ...ray, kind: end === "back" ? "back" : "lost" };
      if (!designed) ray.kind = "stray";
    } else {
      const place = at(ray, window.z), before = (window.z - ray.points.at(-1)[2]) / ray.direction[2];
      if (opening[1] < before) return lost("wall", opening[1]);
      /** @type {any} */
      const slope = [ray.direction[0] / ray.direction[2], ray.direction[1] / ray.direction[2]];
      const bend = bendingOf(window), bent = forward ? bend(slope, place) : unbent(bend, slope, place);
      ray.points.push(place);
      if (!bent) return lost();
      ray.direction = forward ? [...bent, 1] : [-bent[0], -bent[1], -1];
      const wall = within(ray, half, ends)[1];
      if (wall * LARGER < frame / 2) return lost("wall", wall);
    }
  }
  return ray;
}

const LARGER = 1 + 1e-9;  // more than errors of rounding
const along = ({ points, direction }, way) => points.at(-1).map((x, k) => x + way * direction[k]);

// How far along a ray a box begins and ends: |x| and |y| are at most `side`, and z is between `ends`. It misses the box if the first
// number is greater.
function within({ points, direction }, side, ends) {
  const ways = [[-side, side], [-side, side], ends].map((limits, k) => limits.map((x) => (x - points.at(-1)[k]) / direction[k]).sort((a, b) => a - b));
  return [Math.max(...ways.map(([near]) => near)), Math.min(...ways.map(([, far]) => far))];
}

// Where a ray, or its continuation, crosses a plane.
export function at({ points, direction }, z) {
  const last = points.at(-1), way = (z - last[2]) / direction[2];
  return [last[0] + way * direction[0], last[1] + way * direction[1], z];
}

/** @type {WeakMap<object, any>} */
const laws = new WeakMap();  // what `bending` has returned: many rays pass the same window
function bendingOf(window) {
  if (!laws.has(window)) laws.set(window, bending(window));
  return laws.get(window);
}

// The slope before an ideal sheet of an eye's ray that has this slope behind it, from several starts; null if none is found. Many
// laws, such as that of refraction, are nearly linear in the slope's sine.
function unbent(bend, slope, place) {
  const sine = (s) => s && scaled(1 / Math.hypot(1, ...s), s);
  for (const start of [slope, ...STARTS]) {
    const { s, off } = closest(start, sine(slope), (each) => sine(bend(each, place)));
    if (off < 1e-9) return s;
  }
  return null;
}
const STARTS = [[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1], [2, 2], [-2, -2]];

// Steps of numbers that look random, the same each time: rays in a regular grid would make moire with the prisms.
const STEPS = [0.7548776662466927, 0.5698402909980532];

// The rays that are shown: through a grid of places of a window, `count` along a side, the one from the object to the
// eye, or the one to the eye through the chosen point.
export function bundle(now, count = 5) {
  const { L, E, z1, z2, windows, scene, place } = now, half = scene.aperture / 2;
  const eye = [...E, -z2], object = [...L, windows.at(-1).z + z1];
  const between = (from, to) => traced(now, from, to.map((x, k) => x - from[k]));
  const pitch = now.glass ? now.prism.pitch : now.lenses ? scene.aperture / scene.lenses : 0;
  const grid = Array.from({ length: count }, (_, k) => (1.76 * k) / (count - 1) - 0.88);
  const places = grid.flatMap((x) => grid.map((y) => [x * half, y * half]))
    .map((place, n) => plus(place, STEPS.map((step) => pitch * (((0.5 + n * step) % 1) - 0.5))));
  if (state.light === "pencil") return places.map((to) => between(object, [...to, windows.at(-1).z]));
  if (state.light === "eye") return places.map((to) => between(eye, [...to, 0]));
  if (state.light === "aim") return [between(eye, [...state.W, 0])];
  if (!finite(place) || place.some((x) => Math.abs(x) > half)) return [];
  // through prisms, of the rays close to the predicted one, the one on the designed path that comes closest to the object
  const beside = pitch ? [0, 1, -1, 2, -2, 3, -3, 4, -4].map((k) => (k * pitch) / 7) : [0];
  const near = beside.flatMap((x) => beside.map((y) => between(eye, [...plus(place, [x, y]), 0])));
  const miss = (ray) => (ray.kind === "designed" ? abs(minus(at(ray, object[2]), object)) : Infinity);
  return [near.reduce((best, ray) => (miss(ray) < miss(best) ? ray : best))];
}

const RATIO = 0.06;  // rays meet if their bundle is narrower than at the window by this factor

// The centre of the designed rays, whose lines are extended both ways, in the plane z in which the RMS width of their bundle is
// the least. null if it is not narrow there.
export function meeting(rays) {
  const designed = rays.filter(({ kind }) => kind === "designed");
  if (designed.length < 4) return null;
  const mean = (points) => scaled(1 / points.length, points.reduce(plus));
  const places = designed.map((ray) => at(ray, 0).slice(0, 2)), slopes = designed.map(({ direction: [x, y, z] }) => [x / z, y / z]);
  const place = mean(places), slope = mean(slopes), p = places.map((each) => minus(each, place)), q = slopes.map((each) => minus(each, slope));
  const sum = (of) => p.reduce((all, each, k) => all + of(each, q[k]), 0);
  const z = -sum((a, b) => a[0] * b[0] + a[1] * b[1]) / sum((a, b) => abs(b) ** 2);
  const width = (there) => Math.sqrt(sum((a, b) => abs(plus(a, scaled(there, b))) ** 2) / p.length);
  return Math.abs(z) < 1e3 && width(z) < RATIO * width(0) ? [...plus(place, scaled(z, slope)), z] : null;
}

const RAYS = 7000;  // in 130 scenes their shares were wrong by 1.3 points at most: with rounding, by less than 2
let kept = { key: "", found: null };

// The shares of designed and of stray light, as povgen/optics/shares.py defines them, and of the rays that miss a later window.
// Those, and the rest, are lost. null without prisms.
export function lightInWindow(now) {
  if (!now.glass) return null;
  const { E, z2, windows, scene } = now;
  const names = ["prisms", ...Object.keys(data.parameters)];
  const key = JSON.stringify([E, z2, windows.map(({ sheet, z, values }) => [sheet, z, pick(values, ...names)])]);
  if (kept.key === key) return kept.found;
  const count = { designed: 0, stray: 0, back: 0, lost: 0, beside: 0 }, front = z2 - depth(scene) / 2;
  for (let n = 0; n < RAYS; n++) {
    const [x, y] = STEPS.map((step) => (((0.5 + n * step) % 1) - 0.5) * scene.aperture);
    const { kind, frame } = traced(now, [...E, -z2], [x - E[0], y - E[1], front]);
    count[frame === "rim" ? "beside" : kind]++;
  }
  kept = { key, found: { designed: count.designed / RAYS, stray: count.stray / RAYS, beside: count.beside / RAYS } };
  return kept.found;
}

// ---- The field of rays ----

// Light of L on the eye's side of sheets that turn it. Where such light has no image it has no wave fronts either: docs/beyond.md,
// "The field of rays".

const RADIUS = 0.6, START = 1;     // of the loop, and of rays, from the axis through L; how far before the first window the loop begins
const LENGTH = 2, PARTS = 240;     // tiles, of the rays
export const FIELD_RAYS = 24;      // unless some miss the window

// The depth of L, complex, for an eye at the distance w before the first window.
const depthBefore = ({ z1, alpha, behind }, w) => equations.depth(z1, w, alpha, behind);
export const hasField = (now) => Boolean(now.Z || now.two) && !now.glass;

// Rays from L, traced through the windows to some way before the first one: [start, end] of each, there.
export function fieldRays(now) {
  const { L, z1, windows } = now, object = [...L, windows.at(-1).z + z1];
  const places = [RADIUS / 2, RADIUS].flatMap((radius) => Array.from({ length: FIELD_RAYS / 2 }, (_, k) => scaled(radius, turn((4 * k * Math.PI) / FIELD_RAYS))));
  return places.map((place) => traced(now, object, [...place, -z1])).filter(({ kind, direction }) => kind === "designed" && direction[2] < 0)
    .map(({ points, direction }) => [points.at(-1), points.at(-1).map((x, k) => x + (direction[k] * LENGTH) / -direction[2])]);
}

/** A loop once round the axis that is perpendicular to the rays everywhere, and by how far its end is nearer to the sheets than
 * its start. A step dr across the axis goes with dw = -Re(conj(s) dr) for light with the slope s = r/Z: docs/ray_field.py.
 * @param {any} now */
export function perpendicularLoop(now) {
  const rate = (w) => -(RADIUS ** 2) * quotient([1, 0], depthBefore(now, w))[1], step = (2 * Math.PI) / PARTS;
  let w = START;
  const points = Array.from({ length: PARTS + 1 }, (_, k) => {
    if (k) w += step * rate(w + (step / 2) * rate(w));
    return [...plus(now.L, times([RADIUS, 0], turn(k * step))), -w];
  });
  return { points, gap: START - w };
}
