// Where the eye sees a point through windows with sheets of any kinds: povgen/optics/apparent.py. A ray from the eye E with the
// slope s crosses the first window, a distance z2 away, at E + z2 s. The windows are those of `windows` in liveview/presets.js.

import * as geometry from "../liveview/geometry.js";
import { depth } from "../liveview/presets.js";
import { bending, hasPrisms } from "../liveview/sheets.js";
import { abs, conj, determinant, dot, finite, minus, plus, resolved, scaled, times, turn } from "./complex.js";

/** @typedef {number[]} Point */

// The sheets in all windows, those near the eye first: z, the number of the window, and `act`, a map from the slope and the place
// of an eye's ray to those behind the sheet. The slope is null if no light passes. A sheet of prisms has its angle and its prisms'
// shape, too.
function layers(windows) {
  return windows.flatMap((window, number) => {
    if (!hasPrisms(window)) {
      const bend = bending(window);
      return [{ number, z: window.z, act: (s, P) => [bend(s, P), P] }];
    }
    if (window.sheet === "lenticular") return geometry.sheets(window).map((sheet) => ({ number, ...lenses(window, sheet) }));
    const prism = geometry.prism(window.values);
    return geometry.sheets(window).map(({ angle, centre }) => ({
      number, z: window.z + centre, angle, prism,
      act: (s, P) => {
        const mirrored = times(turn(2 * angle), conj(s));
        return [mirrored, plus(P, scaled(-prism.slab_shift / 2, plus(s, mirrored)))];
      },
    }));
  });
}

// A sheet of confocal lenses, for light that leaves through the lens opposite, on average over a lens and for small angles:
// `layer` in povgen/optics/paraxial.py without spherical aberration.
function lenses({ z, values: { ratio, index } }, { angle, centre, length }) {
  const factor = -1 / ratio;
  return {
    z: z + centre, angle,
    act: (s, P) => {
      const [along, across] = times(turn(-angle), s), behind = [along, factor * across];
      const shift = [-length * (1 - 1 / index) * along, length * (1 / index - (1 + factor) / 2) * across];
      return [times(turn(angle), behind), plus(P, times(turn(angle), shift))];
    },
  };
}

// The slope across the lenses up to which most light leaves through the lens opposite.
export const fieldOf = ({ ratio, index, f_number }) => index / (2 * (1 + ratio) * f_number);

// A function that follows the ray with the slope s from the eye. Its path: for each sheet that it meets, the sheet, the slope
// before it, and the place; then slope, place and z behind the last one. The slope is null if no light passes.
export function following(windows, E, z2) {
  const sheets = layers(windows);
  return (/** @type {Point} */ s) => {
    /** @type {any[]} */
    const path = [{ slope: s, place: E, z: -z2 }];
    for (const sheet of sheets) {
      const ray = path.at(-1), { z } = sheet;
      if (!ray.slope) break;
      const met = plus(ray.place, scaled(z - ray.z, ray.slope));
      const [slope, place] = sheet.act(ray.slope, met);
      Object.assign(ray, { sheet, place: met, z });
      path.push({ slope, place, z });
    }
    return path;
  };
}

// Where a path meets a window: its number is 0 or 1. undefined if no light passes so far.
export const meets = (path, window) => path.find(({ sheet }) => sheet?.number === window);

// Where a path crosses the plane a distance z1 behind the last window; null if no light passes.
export function landing(path, windows, z1) {
  const { slope, place, z } = path.at(-1);
  return slope && plus(place, scaled(windows.at(-1).z + z1 - z, slope));
}

// The columns [x, y] of the linear map from a step of the slope at the eye to a step in the plane a distance z1 behind the last
// window, and the point `from` that the slope 0 leads to. null if the map is not linear.
export function linear(windows, E, z1, z2) {
  const at = target(windows, E, z1, z2);
  const from = at([0, 0]);
  if (!from) return null;
  const columns = [[1, 0], [0, 1]].map((step) => at(step) && minus(at(step), from));
  if (!columns.every(Boolean)) return null;
  const most = 1 + Math.max(...columns.map(abs));
  for (const s of [[-1.7, 0.4], [0.9, -1.3], [0.31, 1.87], [-0.6, -1.1], [1.6, 1.2]]) {
    const shown = at(s), expected = plus(from, plus(scaled(s[0], columns[0]), scaled(s[1], columns[1])));
    if (!shown || !(abs(minus(shown, expected)) <= 1e-10 * most)) return null;
  }
  return { columns, from };
}

// A linear map's pole: all light to the eye passes the plane at z1 in one "point", or in a "line"; "" elsewhere.
export function pole(windows, E, z1, z2) {
  const map = linear(windows, E, z1, z2);
  if (!map) return "";
  const [a, b] = map.columns, size = Math.hypot(abs(a), abs(b));
  if (size < 1e-9 * z2) return "point";
  return Math.abs(determinant([a, b])) < 1e-9 * z2 * size ? "line" : "";
}

// How far behind the first window a linear map forms the image of what is at z1: below 0 in front of it, infinite if the light of
// each point leaves in one direction. NaN if there is no image.
export function imageDepth(windows, z1) {
  const [near, far] = [1, 2].map((z2) => linear(windows, [0, 0], z1, z2)?.columns);
  if (!near || !far) return NaN;
  // a ray that meets the first window at P, and had the slope s before, ends at the sum of two linear maps: of P, and of s
  const [ofP, ofS] = [near.map((column, k) => minus(far[k], column)), near.map((column, k) => minus(scaled(2, column), far[k]))];
  if (ofP.every((column) => abs(column) < 1e-9)) return Infinity;
  const W = times(conj(ofP[0]), ofS[0])[0] / abs(ofP[0]) ** 2;
  return ofS.every((column, k) => abs(minus(column, scaled(W, ofP[k]))) < 1e-9 * abs(column)) ? W : NaN;
}

// Where light from L to E crosses the first window: of several paths, one that passes inside all windows' frames, and of several
// such paths the one whose crossing is the nearest to the middle of the window. Close to a caustic, a path that passes L at a
// distance of up to `near` counts too, if there is no other. [NaN, NaN] if there is none.
export function crossing(L, E, z1, z2, windows, near = 0) {
  const map = linear(windows, E, z1, z2);
  if (map) {
    const slope = resolved(minus(L, map.from), map.columns);
    return Math.abs(determinant(map.columns)) < 1e-13 * abs(map.columns[0]) * abs(map.columns[1])
      ? [Infinity, 0] : plus(E, scaled(z2, slope));
  }
  const at = target(windows, E, z1, z2), passes = passing(windows, E, z2);
  const exact = 1e-11 * (abs(minus(L, E)) + z1 + z2);
  let best = [NaN, NaN], least = [true, Infinity, Infinity];
  for (const start of netsOf(windows, E, z1, z2).flatMap((net) => starts(net, L))) {
    const { s, off } = closest(start, L, at);
    if (off > Math.max(exact, near)) continue;
    const P = plus(E, scaled(z2, s)), rank = [!passes(s), off > exact ? off : 0, far(P)];
    const differs = rank.findIndex((value, k) => value !== least[k]);
    if (rank[differs] < least[differs]) [best, least] = [P, rank];
  }
  return best;
}

// A function that says whether the ray with the slope s from the eye passes inside the frames of all windows: their fronts, their
// backs, and the planes of their sheets.
function passing(windows, E, z2) {
  const follow = following(windows, E, z2), { values } = windows[0], d = depth(values) / 2;
  return (s) => follow(s).every(({ sheet, slope, place }, k, path) => {
    if (!sheet) return Boolean(slope);
    const behind = path[k + 1].slope;
    return behind && [place, minus(place, scaled(d, slope)), plus(place, scaled(d, behind))].every((point) => far(point) < values.aperture / 2);
  });
}

// The half side of the square round 0 that a point is on.
const far = (point) => Math.max(...point.map(Math.abs));

// Where light from each point of an outline to E crosses the first window. The search for a point begins at the path from the
// point before it, and over all angles only where it does not lead on from there.
export function crossings(points, E, z1, z2, windows) {
  const at = target(windows, E, z1, z2), single = Boolean(linear(windows, E, z1, z2));
  let last = [NaN, NaN];
  return points.map((L) => {
    const { s, off } = single || !finite(last) ? { s: last, off: Infinity } : closest(scaled(1 / z2, minus(last, E)), L, at);
    const P = plus(E, scaled(z2, s)), found = off <= 1e-11 * (abs(minus(L, E)) + z1 + z2) && abs(minus(P, last)) < STRIDE;
    return (last = found ? P : crossing(L, E, z1, z2, windows));
  });
}
const STRIDE = 0.3;  // tiles, between the crossings of neighbouring points of an outline

// The map from the slope of an eye's ray to the point where it crosses the plane at z1; null if no light passes.
function target(windows, E, z1, z2) {
  const follow = following(windows, E, z2);
  return (/** @type {Point} */ s) => landing(follow(s), windows, z1);
}

const ANGLES = Array.from({ length: 25 }, (_, k) => Math.tan(Math.min(1.55, Math.max(-1.55, ((k - 12) * 7 * Math.PI) / 180))));
const MARGIN = 0.3;  // of a cell's size
const CELLS = 36;    // of the net over the window, in a row
/** @type {any} */
let kept = {};  // those of the last windows

// Nets of rays from which the search starts: over all angles, and over the window. Python's net is finer, for the laws of one's own,
// which the page does not have.
function netsOf(windows, E, z1, z2) {
  const key = String([E, z1, z2]);
  if (kept.windows === windows && kept.key === key) return kept.nets;
  const follow = following(windows, E, z2), half = windows[0].values.aperture / 2;
  const net = (xs, ys) => {
    const shown = ys.map((y) => xs.map((x) => landing(follow([x, y]), windows, z1)));
    return { xs, ys, shown, boxes: boxes(shown) };
  };
  const [xs, ys] = E.map((x) => Array.from({ length: CELLS + 1 }, (_, k) => ((2.2 * k) / CELLS - 1.1) * half / z2 - x / z2));
  const nets = [net(ANGLES, ANGLES), net(xs, ys)];
  kept = { windows, key, nets };
  return nets;
}
// For each cell of a net, in the rows j to j + 1 and the columns k to k + 1: the rectangle, from `low` to `high`, of the points at
// its corners, enlarged by MARGIN of its sides. Points without light are null.
function boxes(points) {
  const found = [];
  for (let j = 0; j + 1 < points.length; j++) {
    for (let k = 0; k + 1 < points[j].length; k++) {
      const low = [Infinity, Infinity], high = [-Infinity, -Infinity];
      for (const point of [points[j][k], points[j][k + 1], points[j + 1][k], points[j + 1][k + 1]]) {
        for (let axis = 0; point && axis < 2; axis++) {
          low[axis] = Math.min(low[axis], point[axis]);
          high[axis] = Math.max(high[axis], point[axis]);
        }
      }
      const more = scaled(MARGIN, minus(high, low));
      found.push({ j, k, low: minus(low, more), high: plus(high, more) });
    }
  }
  return found;
}

// Slopes from which to search: of each cell of the net that may show L, the corner whose ray passes L most closely; and where the
// net's rays pass L more closely than their neighbours.
function starts({ xs, ys, shown, boxes }, L) {
  const off = shown.map((row) => row.map((point) => (point ? abs(minus(point, L)) : Infinity)));
  const least = (places) => places.reduce((best, place) => (off[place[0]]?.[place[1]] < off[best[0]][best[1]] ? place : best));
  const square = (j, k, steps) => steps.flatMap((u) => steps.map((v) => [j + u, k + v]));
  const cells = boxes.filter(({ low, high }) => [0, 1].every((axis) => low[axis] <= L[axis] && L[axis] <= high[axis]));
  const lowest = ys.flatMap((_, j) => xs.map((_, k) => [j, k]))
    .filter(([j, k]) => Number.isFinite(off[j][k]) && square(j, k, [-1, 0, 1]).every(([v, u]) => !(off[v]?.[u] < off[j][k])));
  return [...cells.map(({ j, k }) => least(square(j, k, [0, 1]))), ...lowest].map(([j, k]) => [xs[k], ys[j]]);
}

// The slope near a start whose ray passes L at the least distance, and this distance: Levenberg's and Marquardt's method.
export function closest(start, L, at) {
  const miss = (s) => {
    const shown = at(s);
    return shown ? minus(shown, L) : [NaN, NaN];
  };
  let s = start, f = miss(s), damping = 1e-3;
  for (let step = 0; step < 60 && finite(f) && abs(f) > 0; step++) {
    const h = 1e-7 * (1 + abs(s));
    const [a, b] = [[h, 0], [0, h]].map((d) => scaled(1 / h, minus(miss(plus(s, d)), f)));
    const p = dot(a, a) * (1 + damping), r = dot(b, b) * (1 + damping), ab = dot(a, b);
    const [ga, gb] = [dot(a, f), dot(b, f)], size = p * r - ab ** 2;
    const change = [-(r * ga - ab * gb) / size, -(p * gb - ab * ga) / size];
    if (!finite(change)) break;
    const next = miss(plus(s, change)), better = abs(next) < abs(f);
    const small = abs(change) / (1 + abs(s)) < (better ? 1e-15 : 1e-10);
    if (better) [s, f, damping] = [plus(s, change), next, damping * 0.1];
    else damping = Math.max(damping, 1e-8) * 8;
    if (small || damping > 1e8) break;
  }
  return { s, off: finite(f) ? abs(f) : Infinity };
}
