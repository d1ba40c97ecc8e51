// The paper's equations.
//
// Angles are in radians and lengths in tiles; r is above 0 and finite. Signs and units are as in
// povgen/optics/rotation.py and povgen/optics/paraxial.py. The tests compare these functions with these modules.

import { radians } from "../live/geometry.js";
import { abs, arg, conj, finite, minus, plus, quotient, scaled, times, turn } from "./complex.js";

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

// E - P for L = 0, E = 1.
export const oneMinusP = (r, alpha) => quotient([r, 0], sum(r, 1, -alpha));

// The angle by which an object appears rotated about E: arg(1 - P), eq. 8 corrected.
// It is NaN at the pole, where P is infinite.
export function nu(r, alpha) {
  const inverse = sum(r, 1, -alpha);
  return abs(inverse) === 0 ? NaN : -arg(inverse);
}

// The magnification of an object, compared with the object in the plane of the sheet: |1 - P|, eq. 9 corrected.
export const M = (r, alpha) => abs(oneMinusP(r, alpha));

// The point where light from L crosses an infinitely fine sheet on its way to E: eq. 7. L and E must differ.
export function ideal(L, E, z1, z2, alpha, behind = []) {
  return plus(E, quotient(scaled(z2, minus(L, E)), depth(z1, z2, alpha, behind)));
}

// The complex depth Z of an object: L - E = Z s for light with the slope s at the eye. `behind` are the windows behind the
// first one: the distance from the window before, and the angle. povgen/optics/rotation.py
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

// The same for two sheets of prisms, by the paraxial prediction (docs/sheets.md). `prism` has two lengths of
// povgen/optics/prism.py: slab_shift and separation.
export function prisms(L, E, z1, z2, alpha, prism, behind = []) {
  const { A, B } = depths(z1, z2, alpha, prism, behind);
  const D = minus(L, E);
  const place = minus(times(conj(A), D), times(B, conj(D)));
  return plus(E, scaled(z2 / (abs(A) ** 2 - abs(B) ** 2), place));
}

// The point of the object's plane that is seen at a place of the plane z = 0: the inverse of `prisms`. At the pole of
// an infinitely fine sheet, it is E for every place.
export function behind(place, E, z1, z2, alpha, prism, windows = []) {
  const { A, B } = depths(z1, z2, alpha, prism, windows);
  const D = minus(place, E);
  return plus(E, scaled(1 / z2, plus(times(A, D), times(B, conj(D)))));
}

// The angle by which two sheets of prisms show an object rotated, and its magnification: paraxial.nu_and_M.
export function turned(z1, z2, alpha, prism, behind = []) {
  const { A, B } = depths(z1, z2, alpha, prism, behind);
  const M = (z2 * Math.max(abs(A), abs(B))) / Math.abs(abs(A) ** 2 - abs(B) ** 2);
  return { nu: abs(A) > abs(B) ? -arg(A) : NaN, M };
}

// `prism` is the shape of the prisms in all windows, or a list with that of each.
export function depths(z1, z2, alpha, prism, behind = []) {
  const shapes = (Array.isArray(prism) ? prism : [alpha, ...behind].map(() => prism)).map(sheet);
  let [B, total] = [scaled(shapes[0].b, turn(alpha)), alpha];
  behind.forEach(([, next], k) => {
    total += next;
    B = plus(B, scaled(shapes[k + 1].b, turn(total)));
  });
  const [near, far] = [z2 - shapes[0].h, z1 - shapes.at(-1).h];
  if (!behind.length) return { A: plus([near, 0], scaled(far, turn(-alpha))), B };
  const shorter = behind.map(([distance, next], k) => [distance - shapes[k].h - shapes[k + 1].h, next]);
  return { A: depth(far, near, alpha, shorter), B };
}

// How far an object appears at most from the predicted place, and the numbers of prisms that this depends on: possible_error
// and frequencies of povgen/optics/paraxial.py.
export function possibleError(k, scale, radius, tangent, z2, { reach, slab_shift }, index) {
  const share = (frequency, least) => Math.min(1, (least / (abs(frequency) * radius)) ** 4);
  const shares = k.map((one, i) => {
    const pairs = k.filter((_, j) => j !== i).flatMap((other) => [plus(one, other), minus(one, other)]);
    return Math.max(share(one, 1), ...pairs.map((pair) => share(pair, 0.6)));
  });
  const beyond = (k.length * slab_shift * tangent ** 3 * (index + 1)) / (2 * index ** 2);
  const spread = scale * reach;
  const displaced = spread * Math.max(2 * Math.max(...shares), shares.reduce((a, b) => a + b));
  return displaced + scale * beyond + spread ** 2 / (0.15 * z2);
}

export function frequencies(z2, alpha, prism, behind = []) {
  const { separation: a, slab_shift: g, pitch } = prism;
  let turned = 0;
  return [alpha, ...behind.map(([, next]) => next)].flatMap((next, n) => {
    const before = behind.slice(0, Math.max(0, n - 1));
    const { A, B } = n ? depths(behind[n - 1][0], z2, alpha, prism, before) : { A: [z2, 0], B: [0, 0] };
    const slope = turn(-turned);
    turned += next;
    const near = [minus(A, scaled(a / 2, slope)), B];
    const far = [minus(A, scaled((a + g) / 2, slope)), plus(B, scaled(a - g / 2, turn(turned)))];
    return /** @type {any[][]} */ ([[near, next / 2], [far, 0]]).map(([[c, d], angle]) => (
      scaled(1 / (z2 * pitch), minus(times(c, turn(-angle)), conj(times(d, turn(-angle)))))));
  });
}

function sheet({ slab_shift, separation }) {
  return { b: separation - slab_shift, h: (separation + slab_shift) / 2 };
}

// The point where light from L crosses the plane z = 0 if there is a single sheet: paraxial.mirrored_position.
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

// ---- The other ideal sheets: povgen/optics/ideal.py ----

// The direction [x, y, z], behind one of the other sheets, of a line of sight d, or null if no light passes.
export function bent(d, { sheet, alpha: degrees, ratio, axis }) {
  const alpha = radians(degrees);
  const transverse = [d[0], d[1]], length = Math.hypot(...d);
  const back = times(transverse, turn(-alpha));
  let found;
  if (sheet === "mirror") found = [...times(conj(transverse), turn(alpha)), d[2]];
  else if (sheet === "lenslets") found = [...scaled(1 / ratio, back), d[2]];
  else if (sheet === "refraction") {
    const sine = scaled(1 / (ratio * length), back);
    found = [...sine, Math.sqrt(1 - abs(sine) ** 2)];
  } else {
    const [x, y, z] = axis.map((part) => part / Math.hypot(...axis));
    const [c, s] = turn(-alpha);
    const along = (x * d[0] + y * d[1] + z * d[2]) * (1 - c);
    found = [
      c * d[0] + s * (y * d[2] - z * d[1]) + x * along,
      c * d[1] + s * (z * d[0] - x * d[2]) + y * along,
      c * d[2] + s * (x * d[1] - y * d[0]) + z * along,
    ];
  }
  return found[2] > 0 ? found : null;
}

// Where light from L to E crosses one of the other sheets: of several paths, the one whose crossing is the nearest to the
// middle of the window. Close to a caustic, a path that passes L at a distance of up to `near` counts too. [NaN, NaN] if
// there is none.
export function crossing(L, E, z1, z2, { sheet, alpha: degrees, ratio, axis }, near = 0) {
  const D = minus(L, E), alpha = radians(degrees);
  if (sheet === "lenslets") return ideal(L, E, z1 / ratio, z2, alpha);
  if (sheet === "mirror") {
    const [place, eye] = [L, E].map((point) => times(point, turn(-alpha / 2)));  // the mirror's line becomes the x axis
    return times(mirrored(place, eye, z1, z2, { slab_shift: 0 }), turn(alpha / 2));
  }
  const paths = sheet === "axis" ? rotatedPaths(D, z1, z2, axis, alpha) : refractedPaths(D, z1, z2, ratio, alpha);
  const places = paths.filter(({ miss }) => miss <= near).map(({ slope }) => plus(E, scaled(z2, slope))).filter(finite);
  const far = (place) => Math.max(...place.map(Math.abs));
  return places.length ? places.reduce((a, b) => (far(b) < far(a) ? b : a)) : [NaN, NaN];
}

// Light that a sheet rotates about an axis: its slopes at the eye, and how far from L it passes. ideal.position_by_rotation
function rotatedPaths(D, z1, z2, axis, alpha) {
  const [x, y, z] = axis.map((part) => part / Math.hypot(...axis));
  const [c, s] = turn(alpha), k = 1 - c;
  const R = [
    [c + k * x * x, k * x * y - s * z, k * x * z + s * y],
    [k * x * y + s * z, c + k * y * y, k * y * z - s * x],
    [k * x * z - s * y, k * y * z + s * x, c + k * z * z],
  ];
  const RK = R.map(([a, b, c]) => [-z2 * a, -z2 * b, D[0] * a + D[1] * b + z1 * c]);
  // the eigenvalues of RK: the zeros of q^3 - trace q^2 + minors q - product
  const trace = RK[0][0] + RK[1][1] + RK[2][2], product = z1 * z2 ** 2;
  const minors = PAIRS.reduce((sum, [i, j]) => sum + RK[i][i] * RK[j][j] - RK[i][j] * RK[j][i], 0);
  const root = Math.sqrt(trace ** 2 - 3 * minors);
  const turning = [(trace - root) / 3, (trace + root) / 3].filter((q) => q > 0);
  const most = 1 + Math.abs(trace) + Math.abs(minors) + product;
  const exact = zeros((q) => ((q - trace) * q + minors) * q - product, [0, ...turning, most]);
  const others = (trace - exact[0]) / 2;  // the mean of the other two; the product of all three is positive
  const close = exact.length === 1 && others > 0 ? [others] : [];
  /** @type {(value: number) => any} */
  const slope = (value) => {
    const rows = RK.map((row, i) => row.map((a, j) => a - (i === j ? value : 0)));
    // the vector at right angles to all rows
    const [vx, vy, vz] = PAIRS.map(([i, j]) => cross(rows[i], rows[j])).reduce((a, b) => (Math.hypot(...b) > Math.hypot(...a) ? b : a));
    return Math.abs(vz) > 1e-9 * Math.hypot(vx, vy) ? [vx / vz, vy / vz] : [NaN, NaN];
  };
  const miss = ([u, v]) => {
    const ray = [0, 1, 2].map((i) => R[0][i] * u + R[1][i] * v + R[2][i]);
    return ray[2] > 0 ? abs(minus(plus(scaled(z2, [u, v]), scaled(z1 / ray[2], ray)), D)) : NaN;
  };
  return [...exact.map((q) => ({ slope: slope(q), miss: 0 })), ...close.map(slope).map((s) => ({ slope: s, miss: miss(s) }))];
}

const PAIRS = [[0, 1], [0, 2], [1, 2]];
/** @type {(a: any, b: any) => number[]} */
const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];

// The same for light that a sheet refracts: ideal.position_by_refraction.
function refractedPaths(D, z1, z2, ratio, alpha) {
  const least = Math.min(1, ratio), c = Math.cos(alpha), q = (ratio * z2 / z1) ** 2;
  const squares = (p) => {
    const eye = (least * Math.cos(p)) ** 2;
    return [eye + (1 - least ** 2), eye + (ratio ** 2 - least ** 2)];
  };
  const Z = (p) => {
    const [near, far] = squares(p);
    return plus([z2, 0], scaled(z1 * Math.sqrt(near / far), turn(-alpha)));
  };
  const beyond = (p) => abs(Z(p)) * least * Math.sin(p) / Math.sqrt(squares(p)[0]) - abs(D);
  const most = 2 + 2 * Math.abs(c) * (1 + q);
  // where the quartic has its minimum, where it is 0, and the p of these zeros
  const lowest = zeros((w) => (4 * w + 3 * c) * w ** 2 + c * q, [0, most]);
  const squared = zeros((w) => (w + c) * w ** 3 + (c * w + 1) * q, [0, ...lowest, most]).map((w) => (w * z1 / z2) ** 2);
  const turning = squared.map((square) => Math.asin(Math.sqrt((ratio ** 2 - square) / (1 - square)) / least));
  const numbers = [0, ...turning.filter((p) => p > 0).sort((a, b) => a - b), Math.PI / 2];
  const side = numbers.map((p) => beyond(p) > 0);
  const exact = zeros(beyond, numbers);
  const close = numbers.filter((_, k) => 0 < k && k < numbers.length - 1 && side[k - 1] === side[k] && side[k] === side[k + 1]);
  const path = (p, off) => ({ slope: quotient(scaled(1 + off / abs(D), D), Z(p)), miss: Math.abs(off) });
  return [...exact.map((p) => ({ slope: quotient(D, Z(p)), miss: 0 })), ...close.map((p) => path(p, beyond(p)))];
}

// Where a function is 0: by bisection, once between any two of the given numbers between which its sign changes.
function zeros(f, numbers) {
  return numbers.slice(1).flatMap((end, k) => {
    let [low, high] = [numbers[k], end];
    const positive = f(low) > 0;
    if (positive === f(high) > 0) return [];
    for (let middle = (low + high) / 2; low < middle && middle < high; middle = (low + high) / 2) {
      if (positive === f(middle) > 0) low = middle;
      else high = middle;
    }
    return [(low + high) / 2];
  });
}

// Where the light from L to E crosses the second window.
export function atSecondWindow({ E, place, z2, d, alpha }) {
  const slope = scaled(1 / z2, minus(place, E));
  return plus(place, scaled(d, times(slope, turn(-alpha))));
}
