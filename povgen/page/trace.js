// The exact ray trace through the sheets of prisms, or of lenses, in a window, with numbers of 64 bits: `Profiles` in
// povgen/optics/faces.py, and povgen/optics/trace.py, whose comments explain the method. x, y and z are the scene's, in tiles.

import { outlines, sheets } from "../liveview/geometry.js";

const BORDER = 255;       // in place of an edge: the border between two cells
const ROUNDING = 1e-12;   // of an edge's size: by how much a ray may miss its end

/** What does not depend on the ray, of the last window: many rays pass the same one.
 * @type {any} */
let known = {};

const copysign = (size, sign) => (sign < 0 ? -size : size);

// Edge number `number` in tiles: its start and its direction, the centre of its circle, and by how much a ray may miss its end. Its
// normal out of the glass is (tz, -tu). `Edge` in povgen/optics/profile.py
function edgeOf([su, sz, eu, ez, radius], number, pitch) {
  const chord = Math.hypot(eu - su, ez - sz), [tu, tz] = [(eu - su) / chord, (ez - sz) / chord];
  const aside = -copysign(Math.sqrt(Math.max(0, radius ** 2 - chord ** 2 / 4)), radius);
  const [cu, cz] = radius ? [(su + eu) / 2 + aside * tz, (sz + ez) / 2 - aside * tu] : [su, sz];
  return { number, su, sz, tu, tz, chord, cu, cz, radius, least: ROUNDING * Math.max(pitch, Math.abs(radius)) };
}

/** Follow a ray through the sheets of a window. It starts outside of them and runs towards them. `frame` is the extent of the
 * window's frame along z. `steps` are the edges of the cross-section that the ray meets: where, the number of the edge from 1, and
 * whether it reflects the ray totally. `end` is "through", "back" (leaves where it came from), "frame", or "unfinished" (has
 * met `most` edges). `designed`: whether it took the designed path. `place` and `direction` are those at its end.
 * @param {any} window */
export function passage(window, from, towards, { most = 60, frame = 0 } = {}) {
  if (window !== known.window) {
    const { pitch, half, index, edges, path } = outlines(window);
    known = { window, pitch, half: pitch * half, index, path, layers: sheets(window), edges: edges.map((edge, n) => edgeOf(edge.map((x) => pitch * x), n + 1, pitch)) };
  }
  const { pitch, half, index, path, layers, edges } = known, halfWindow = window.values.aperture / 2;
  const size = Math.hypot(...towards), forward = towards[2] > 0;
  let place = [from[0], from[1], from[2] - window.z], direction = towards.map((x) => x / size);
  let orders = 0;  // how many lenses lie between that by which a ray has entered a sheet and that by which it has left it
  let at = forward ? 0 : layers.length - 1;
  const steps = [];
  const isOutside = (x, y) => Math.max(Math.abs(x), Math.abs(y)) > halfWindow;

  const ended = (end) => {
    const wanted = layers.flatMap(() => (forward ? path : path.toReversed()));
    const designed = end === "through" && !orders && steps.length === wanted.length && steps.every(({ face }, n) => face === wanted[n]);
    return { place: [place[0], place[1], place[2] + window.z], direction, end, steps, designed };
  };

  for (;;) {
    if (at < 0 || at === layers.length) {
      const way = Math.max(0, (copysign(frame / 2, direction[2]) - place[2]) / direction[2]);
      if (isOutside(place[0] + way * direction[0], place[1] + way * direction[1])) return ended("frame");
      return ended((direction[2] > 0) === forward ? "through" : "back");
    }
    // To the surface of the next sheet. From there on x, u and z are the sheet's own, with u above the bottom of cell `cell`.
    const { angle, centre } = layers[at], [c, s] = [Math.cos(angle), Math.sin(angle)];
    const surface = copysign(half, -direction[2]);
    const way = (surface - place[2] + centre) / direction[2];
    const [X, Y] = [0, 1].map((k) => place[k] + way * direction[k]);
    if (isOutside(X, Y)) {
      place = [X, Y, surface + centre];
      return ended("frame");
    }
    const v = c * Y - s * X + halfWindow;
    let cell = Math.floor(v / pitch), glass = false;
    let [x, u, z] = [c * X + s * Y, v - cell * pitch, surface];
    let entered = NaN, last = NaN, t = 0, face = 0, nu = 0, nz = 0;
    let [dx, dy, dz] = [c * direction[0] + s * direction[1], c * direction[1] - s * direction[0], direction[2]];
    const outside = () => {
      const y = u + cell * pitch - halfWindow;
      place = [c * x - s * y, s * x + c * y, z + centre];
      direction = [c * dx - s * dy, s * dx + c * dy, dz];
      return isOutside(place[0], place[1]);
    };
    for (;;) {
      meetEdge();
      x += t * dx;
      u += t * dy;
      z += t * dz;
      if (outside()) return ended("frame");
      if (!face) break;
      if (face === BORDER) {
        [cell, u] = dy > 0 ? [cell + 1, 0] : [cell - 1, pitch];
        continue;
      }
      if (Number.isNaN(entered)) entered = cell;
      last = cell;
      const along = nu * dy + nz * dz, eta = glass ? index : 1 / index;
      const square = 1 - eta ** 2 * (1 - along ** 2), total = square < 0;
      steps.push({ place: [place[0], place[1], place[2] + window.z], face, total });
      const change = total ? -2 * along : copysign(Math.sqrt(square), along) - eta * along, scale = total ? 1 : eta;
      [dx, dy, dz] = [scale * dx, scale * dy + change * nu, scale * dz + change * nz];
      if (!total) glass = !glass;
      if (steps.length === most) {
        outside();
        return ended("unfinished");
      }
    }
    if (last !== entered && !Number.isNaN(last)) orders++;
    at += direction[2] > 0 ? 1 : -1;

    // Find the edge or the border that the ray meets first: `face` is its number, and 0 if the ray leaves the sheet. Only edges count
    // that it crosses in the right direction: so it does not meet the edge again that it has just met.
    function meetEdge() {
      const outwards = glass ? 1 : -1, square = dy * dy + dz * dz;
      [t, face] = [dy === 0 ? Infinity : ((dy > 0 ? pitch : 0) - u) / dy, BORDER];
      for (const { number, su, sz, tu, tz, chord, cu, cz, radius, least } of edges) {
        const qu = u - cu, qz = z - cz;
        let reach;
        if (radius) {
          const b = qu * dy + qz * dz, root = b * b - square * (qu * qu + qz * qz - radius * radius);
          reach = (outwards * Math.sign(radius) * Math.sqrt(root) - b) / square;  // NaN: it misses the circle
        } else {
          const speed = tz * dy - tu * dz;
          reach = speed * outwards > 0 ? (tu * qz - tz * qu) / speed : NaN;
        }
        if (!(reach > -least && reach < t)) continue;
        const hu = u + reach * dy - su, hz = z + reach * dz - sz, along = tu * hu + tz * hz;
        if (along < -least || along > chord + least || (radius && Math.sign(radius) * (tz * hu - tu * hz) < -least)) continue;  // the circle's other part
        [t, face] = [reach, number];
        [nu, nz] = radius ? [(qu + reach * dy) / radius, (qz + reach * dz) / radius] : [tz, -tu];
      }
      t = Math.max(t, 0);
      const side = glass || dz === 0 ? Infinity : Math.max((copysign(half, dz) - z) / dz, 0);
      if (side < t || (side === t && face === BORDER)) [t, face] = [side, 0];
    }
  }
}
