// Complex numbers, [re, im].

/** @type {(a: number[], b: number[]) => any} */
export const minus = (a, b) => [a[0] - b[0], a[1] - b[1]];
/** @type {(a: number[], b: number[]) => any} */
export const plus = (a, b) => [a[0] + b[0], a[1] + b[1]];
/** @type {(a: number[], b: number[]) => any} */
export const times = (a, b) => [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
/** @type {(k: number, a: number[]) => any} */
export const scaled = (k, a) => [k * a[0], k * a[1]];
/** @type {(a: number[]) => any} */
export const conj = (a) => [a[0], -a[1]];
/** @type {(a: number[], b: number[]) => number} */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1];
export const abs = (a) => Math.hypot(a[0], a[1]);
export const arg = (a) => Math.atan2(a[1], a[0]);
/** @type {(angle: number) => any} */
export const turn = (angle) => [Math.cos(angle), Math.sin(angle)];
export const finite = (a) => Number.isFinite(a[0]) && Number.isFinite(a[1]);

// The signed area of the parallelogram of two vectors; negative if the second one is clockwise of the first.
/** @type {(vectors: number[][]) => number} */
export const determinant = ([a, b]) => a[0] * b[1] - a[1] * b[0];

// The numbers [s, t] with s a + t b = v.
/** @type {(v: number[], vectors: number[][]) => any} */
export const resolved = (v, [a, b]) => scaled(1 / determinant([a, b]), [determinant([v, b]), determinant([a, v])]);

// a/b for a other than 0. If b is 0, the result is infinite.
export function quotient(a, b) {
  const size = b[0] ** 2 + b[1] ** 2;
  return size === 0 ? [Infinity, 0] : scaled(1 / size, times(a, conj(b)));
}
