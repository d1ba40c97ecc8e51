// Complex numbers and the paper's equations.

"use strict";

// ---- Complex numbers, [re, im] ----

const minus = (a, b) => [a[0] - b[0], a[1] - b[1]];
const plus = (a, b) => [a[0] + b[0], a[1] + b[1]];
const times = (a, b) => [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
const scaled = (k, a) => [k * a[0], k * a[1]];
const conj = (a) => [a[0], -a[1]];
const abs = (a) => Math.hypot(a[0], a[1]);
const arg = (a) => Math.atan2(a[1], a[0]);
const turn = (angle) => [Math.cos(angle), Math.sin(angle)];
const finite = (a) => Number.isFinite(a[0]) && Number.isFinite(a[1]);

// The signed area of the parallelogram of two vectors; negative if the second one is clockwise of the first.
const determinant = ([a, b]) => a[0] * b[1] - a[1] * b[0];

// The numbers [s, t] with s a + t b = v.
const resolved = (v, [a, b]) => scaled(1 / determinant([a, b]), [determinant([v, b]), determinant([a, v])]);

// a/b for a other than 0. If b is 0, the result is infinite.
function quotient(a, b) {
  const size = b[0] ** 2 + b[1] ** 2;
  return size === 0 ? [Infinity, 0] : scaled(1 / size, times(a, conj(b)));
}

// ---- The equations ----
// Angles are in radians and lengths in tiles; r is above 0 and finite. Signs and units are as in
// povgen/optics/rotation.py and povgen/optics/paraxial.py. The tests compare these functions with these modules.

const equations = (() => {
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
  const P = (r, alpha) => quotient([1, 0], sum(1, r, alpha));

  // E - P for L = 0, E = 1.
  const oneMinusP = (r, alpha) => quotient([r, 0], sum(r, 1, -alpha));

  // The angle by which an object appears rotated about E: arg(1 - P), eq. 8 corrected.
  // It is NaN at the pole, where P is infinite.
  function nu(r, alpha) {
    const inverse = sum(r, 1, -alpha);
    return abs(inverse) === 0 ? NaN : -arg(inverse);
  }

  // The magnification of an object, compared with the object in the plane of the sheet: |1 - P|, eq. 9 corrected.
  const M = (r, alpha) => abs(oneMinusP(r, alpha));

  // The point where light from L crosses an infinitely fine sheet on its way to E: eq. 7. L and E must differ.
  function ideal(L, E, z1, z2, alpha, behind = []) {
    return plus(E, quotient(scaled(z2, minus(L, E)), depth(z1, z2, alpha, behind)));
  }

  // The complex depth Z of an object: L - E = Z s for light with the slope s at the eye. `behind` are the windows behind the
  // first one: the distance from the window before, and the angle. povgen/optics/rotation.py
  function depth(z1, z2, alpha, behind = []) {
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
  function prisms(L, E, z1, z2, alpha, prism, behind = []) {
    const { A, B } = depths(z1, z2, alpha, prism, behind);
    const D = minus(L, E);
    const place = minus(times(conj(A), D), times(B, conj(D)));
    return plus(E, scaled(z2 / (abs(A) ** 2 - abs(B) ** 2), place));
  }

  // The point of the object's plane that is seen at a place of the plane z = 0: the inverse of `prisms`. At the pole of
  // an infinitely fine sheet, it is E for every place.
  function behind(place, E, z1, z2, alpha, prism, windows = []) {
    const { A, B } = depths(z1, z2, alpha, prism, windows);
    const D = minus(place, E);
    return plus(E, scaled(1 / z2, plus(times(A, D), times(B, conj(D)))));
  }

  // The angle by which two sheets of prisms show an object rotated, and its magnification: paraxial.nu_and_M.
  function turned(z1, z2, alpha, prism, behind = []) {
    const { A, B } = depths(z1, z2, alpha, prism, behind);
    const M = (z2 * Math.max(abs(A), abs(B))) / Math.abs(abs(A) ** 2 - abs(B) ** 2);
    return { nu: abs(A) > abs(B) ? -arg(A) : NaN, M };
  }

  // `prism` is the shape of the prisms in all windows, or a list with that of each.
  function depths(z1, z2, alpha, prism, behind = []) {
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

  function sheet({ slab_shift, separation }) {
    return { b: separation - slab_shift, h: (separation + slab_shift) / 2 };
  }

  // The point where light from L crosses the plane z = 0 if there is a single sheet: paraxial.mirrored_position.
  function mirrored(L, E, z1, z2, prism) {
    const [x, y] = minus(L, E);
    return plus(E, scaled(z2, [x / (z2 + z1 - prism.slab_shift), y ? y / (z2 - z1) : 0]));
  }

  // The values of z1 at which a curve of constant alpha passes through infinity, or comes nearest to infinity.
  // To get the values of z2 instead, pass z1 as the first argument.
  function infiniteZ1(z2, alpha, prism) {
    const { b, h } = sheet(prism);
    const half = Math.sqrt(Math.max(0, b ** 2 - ((z2 - h) * Math.sin(alpha)) ** 2));
    return [-half, half].map((aside) => h - (z2 - h) * Math.cos(alpha) + aside);
  }

  // The same for alpha, along a curve of constant r.
  function infiniteAlpha(z1, z2, prism) {
    const { b, h } = sheet(prism);
    const cosine = (b ** 2 - (z2 - h) ** 2 - (z1 - h) ** 2) / (2 * (z2 - h) * (z1 - h));
    const alpha = Math.acos(Math.min(1, Math.max(-1, cosine)));
    return [-alpha, alpha];
  }

  return { P, oneMinusP, nu, M, ideal, prisms, behind, mirrored, turned, depth, infiniteZ1, infiniteAlpha };
})();

const radians = (degrees) => degrees * (Math.PI / 180);

// ---- The other ideal sheets: maps of directions, povgen/optics/ideal.py ----

// The direction [x, y, z], behind one of the other sheets, of a line of sight d, or null if no light passes.
function bent(d, { sheet, alpha: degrees, ratio, axis }) {
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

// Where light from L to E crosses one of the other sheets: Newton's method, as in povgen/optics/ideal.py. [NaN, NaN] if no
// path was found.
function crossing(L, E, z1, z2, scene) {
  const missed = (slope) => {
    const ray = bent([...slope, 1], scene);
    if (!ray) return [NaN, NaN];
    return minus(plus(E, plus(scaled(z2, slope), scaled(z1 / ray[2], [ray[0], ray[1]]))), L);
  };
  const size = 1 + abs(minus(L, E)) + z1 + z2;
  let slope = [0, 0], off = missed(slope);
  for (let k = 0; k < 60 && abs(off) > 1e-13 * size; k++) {
    const steps = [[1e-7, 0], [0, 1e-7]].map((h) => scaled(5e6, minus(missed(plus(slope, h)), missed(minus(slope, h)))));
    let step = scaled(-1, resolved(off, steps));
    let next = missed(plus(slope, step));
    for (let n = 0; n < 30 && !(abs(next) <= abs(off)); n++) {
      step = scaled(0.5, step);
      next = missed(plus(slope, step));
    }
    if (!finite(next)) break;
    slope = plus(slope, step);
    off = next;
  }
  return abs(off) < 1e-9 * size ? plus(E, scaled(z2, slope)) : [NaN, NaN];
}

// Where the light from L to E crosses the second window.
function atSecondWindow({ E, place, z2, d, alpha }) {
  const slope = scaled(1 / z2, minus(place, E));
  return plus(place, scaled(d, times(slope, turn(-alpha))));
}
