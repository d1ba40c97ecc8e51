// The paper's equations.
//
// Angles are in radians and lengths in tiles; r is above 0 and finite. Signs and units are as in
// povgen/optics/equations.py and povgen/optics/apparent.py. The tests compare these functions with these modules.

import { abs, arg, conj, minus, plus, quotient, scaled, times, turn } from "./complex.js";

// a + b exp(i alpha) for a, b >= 0 without cancellation: (a - b) + 2b cos(alpha/2) exp(i alpha/2).
function sum(a, b, alpha) {
  const half = alpha / 2;
  const cosine = Math.cos(half);
  // pi is not a double: for a = b, its nearest double is treated as pi
  const atPi = a === b && Math.abs(cosine) <= spacing(Math.abs(half)) / 2;
  const product = atPi ? 0 : 2 * b * cosine;
  return [a - b + product * Math.cos(half), product * Math.sin(half)];
}

// The distance from x >= 0 to the next greater double.
function spacing(x) {
  const number = new Float64Array([x]);
  new BigUint64Array(number.buffer)[0] += 1n;
  return number[0] - x;
}

// The point where light from L = 0 crosses the sheet on its way to E = 1: eq. 7.
export const P = (r, alpha) => quotient([1, 0], sum(1, r, alpha));

// The angle by which an object appears rotated about E: arg(1 - P), eq. 8 corrected. It is NaN at the pole, where P is infinite.
export const nu = (r, alpha) => turned(1, r, alpha).nu;

// The magnification of an object, compared with the object in the plane of the sheet: |1 - P|, eq. 9 corrected.
export const M = (r, alpha) => turned(1, r, alpha).M;

// The complex depth Z of an object: L - E = Z s for light with the slope s at the eye. `behind` are the windows behind the
// first one: the distance from the window before, and the angle. povgen/optics/equations.py
export function depth(z1, z2, alpha, behind = []) {
  if (!behind.length) return sum(z2, z1, -alpha);
  let [Z, angle, all] = [[z2, 0], -alpha, Math.abs(z2) + Math.abs(z1)];
  for (const [distance, next] of behind) {
    Z = plus(Z, scaled(distance, turn(angle)));
    angle -= next;
    all += Math.abs(distance);
  }
  Z = plus(Z, scaled(z1, turn(angle)));
  return abs(Z) <= 1e-14 * all ? [0, 0] : Z;  // no more than rounding errors
}

// The point where light from L crosses the first window on its way to E: eq. 7, and for sheets of prisms the paraxial prediction
// (docs/sheets.md). `prisms` has two lengths of povgen/optics/prism.py for each window, slab_shift and separation; an ideal sheet
// has none. L and E must differ.
export function position(L, E, z1, z2, alpha, prisms = [], behind = []) {
  const { A, B, area } = depths(z1, z2, alpha, prisms, behind), D = minus(L, E);
  return area === 0 ? [Infinity, 0] : plus(E, scaled(z2 / area, minus(times(conj(A), D), times(B, conj(D)))));
}

// The angle by which an object appears rotated, NaN if it has none, and its magnification: apparent.nu_and_M.
export function turned(z1, z2, alpha, prisms = [], behind = []) {
  const { A, B, area } = depths(z1, z2, alpha, prisms, behind);
  return { nu: abs(A) > abs(B) ? -arg(A) : NaN, M: area === 0 ? Infinity : (z2 * Math.max(abs(A), abs(B))) / Math.abs(area) };
}

// L - E = A s + B conj(s) for light with the slope s at the eye; `area` is the determinant of this map.
function depths(z1, z2, alpha, prisms, behind) {
  const shapes = [0, ...behind].map((_, k) => sheet(prisms[k]));
  let [B, total] = [scaled(shapes[0].b, turn(alpha)), alpha];
  behind.forEach(([, next], k) => {
    total += next;
    B = plus(B, scaled(shapes[k + 1].b, turn(total)));
  });
  const shorter = behind.map(([distance, next], k) => [distance - shapes[k].h - shapes[k + 1].h, next]);
  const A = depth(z1 - shapes.at(-1).h, z2 - shapes[0].h, alpha, shorter);
  return { A, B, area: abs(A) ** 2 - abs(B) ** 2 };
}

const sheet = ({ slab_shift = 0, separation = 0 } = {}) => ({ b: separation - slab_shift, h: (separation + slab_shift) / 2 });

// The point where light from L crosses the plane z = 0 if there is a single sheet: `apparent.single`.
export function mirrored(L, E, z1, z2, prism) {
  const [x, y] = minus(L, E);
  return plus(E, scaled(z2, [x / (z2 + z1 - prism.slab_shift), y ? y / (z2 - z1) : 0]));
}

// The values of z1 at which a curve of constant alpha passes through infinity, or comes nearest to infinity.
// To get the values of z2 instead, pass z1 as the first argument.
export function infiniteZ1(z2, alpha, prism) {
  const { b, h } = sheet(prism);
  const half = Math.sqrt(Math.max(0, b ** 2 - ((z2 - h) * Math.sin(alpha)) ** 2));
  return [-half, half].map((aside) => h - (z2 - h) * Math.cos(alpha) + aside);
}

// The same for alpha, along a curve of constant r.
export function infiniteAlpha(z1, z2, prism) {
  const { b, h } = sheet(prism);
  const cosine = (b ** 2 - (z2 - h) ** 2 - (z1 - h) ** 2) / (2 * (z2 - h) * (z1 - h));
  const alpha = Math.acos(Math.min(1, Math.max(-1, cosine)));
  return [-alpha, alpha];
}
