// The field of rays: light of L on the eye's side of sheets that turn it. Where such light has no image it has no wave fronts
// either: docs/beyond.md, "The field of rays". Points are [x, y, z], in tiles.

import { plus, quotient, scaled, times, turn } from "./complex.js";
import * as equations from "./equations.js";
import { traced } from "./rays.js";

const RADIUS = 0.6, START = 1;     // of the loop, and of rays, from the axis through L; how far before the first window the loop begins
const LENGTH = 2, STEPS = 240;     // tiles, of the rays

// The depth of L, complex, for an eye at the distance w before the first window.
const depth = ({ z1, alpha, behind }, w) => equations.depth(z1, w, alpha, behind);
export const hasField = (now) => Boolean(now.Z || now.two) && !now.glass;

// Rays from L, traced through the windows to some way before the first one: [start, end] of each, there.
export function fieldRays(now) {
  const { L, z1, windows } = now, object = [...L, windows.at(-1).z + z1];
  const places = [RADIUS / 2, RADIUS].flatMap((radius) => Array.from({ length: 12 }, (_, k) => scaled(radius, turn((k * Math.PI) / 6))));
  return places.map((place) => traced(now, object, [...place, -z1])).filter(({ kind, direction }) => kind === "designed" && direction[2] < 0)
    .map(({ points, direction }) => [points.at(-1), points.at(-1).map((x, k) => x + (direction[k] * LENGTH) / -direction[2])]);
}

/** A loop once round the axis that is perpendicular to the rays everywhere, and by how far its end is nearer to the sheets than
 * its start. A step dr across the axis goes with dw = -Re(conj(s) dr) for light with the slope s = r/Z: docs/ray_field.py.
 * @param {any} now */
export function perpendicularLoop(now) {
  const rate = (w) => -(RADIUS ** 2) * quotient([1, 0], depth(now, w))[1], step = (2 * Math.PI) / STEPS;
  let w = START;
  const points = Array.from({ length: STEPS + 1 }, (_, k) => {
    if (k) w += step * rate(w + (step / 2) * rate(w));
    return [...plus(now.L, times([RADIUS, 0], turn(k * step))), -w];
  });
  return { points, gap: START - w };
}
