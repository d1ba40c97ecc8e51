// Shapes in SVG. Points are [x, y] with y down. Angles are as the eye sees them: counter-clockwise.

import { abs, conj, finite, minus, plus, scaled, turn } from "./complex.js";

export function svg(tag, attributes, text = "") {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.textContent = text;
  return node;
}
// The data of a path along lines of points; of closed lines, `end` is "Z".
export const along = (lines, end = "") => lines.map((points) => `M${points.map((point) => point.map((x) => x.toFixed(1)).join(" ")).join("L")}${end}`).join("");
export const dot = (kind, [cx, cy], r, id = "") => svg("circle", { class: kind, cx, cy, r, ...(id && { id }) });
export const line = (kind, [x1, y1], [x2, y2]) => svg("line", { class: kind, x1, y1, x2, y2 });
// Drawings run from left to right. Text in letters from right to left keeps its own direction inside them.
export const words = (kind, [x, y], text) => svg("text", { class: kind, x, y }, /[\u0590-\u08ff]/.test(text) ? `\u2067${text}\u2069` : text);
export const step = (from, angle, length) => plus(from, scaled(length, conj(turn(angle))));

export const heading = (from, to) => Math.atan2(from[1] - to[1], to[0] - from[0]);

// A curve through points. It is interrupted at null, and at points far outside the drawing.
export function curve(kind, points) {
  /** @type {number[][][]} */
  const lines = [[]];
  for (const point of points) {
    if (point && finite(point) && abs(point) < 4000) lines.at(-1).push(point);
    else if (lines.at(-1).length) lines.push([]);
  }
  return svg("path", { class: kind, d: along(lines.filter(({ length }) => length)) });
}

// Points of a curve between two parameters. Where the curve may pass through infinity it is interrupted, and the points
// near there are closer together.
export function branches(place, first, last, infinite = []) {
  const within = infinite.filter((at) => first < at && at < last).sort((a, b) => a - b);
  const ends = [first, ...within, last];
  return within.concat(last).flatMap((end, n) => {
    const start = ends[n];
    return [...SHARES.map((share) => place(start + (end - start) * share)), null];
  });
}

// An arc that begins at the angle `start` and extends by the angle `through`.
export function arc(kind, centre, radius, start, through) {
  const steps = Array.from({ length: 41 }, (_, n) => step(centre, start + (through * n) / 40, radius));
  return curve(kind, steps);
}

export function arrowhead(kind, tip, angle, length) {
  const corners = [tip, step(tip, angle + 2.7, length), step(tip, angle - 2.7, length)];
  return svg("polygon", { class: kind, points: corners.map((corner) => corner.join(",")).join(" ") });
}

// A line that stops just short of the dot at its end. It has an arrowhead unless it is too short.
export function vector(kind, from, to, rem) {
  const [x, y] = minus(to, from);
  const length = Math.hypot(x, y) - 0.4 * rem;
  if (length < 0.8 * rem) return [line(kind, from, to)];
  const angle = heading(from, to);
  return [
    line(kind, from, step(from, angle, length - 0.5 * rem)),
    arrowhead(`head ${kind}`, step(from, angle, length), angle, 0.75 * rem),
  ];
}

// For a point outside a picture: the tip and the angle of an arrow at the edge that points to it. Otherwise null.
export function edge(place, { width, height }, margin) {
  const excess = Math.max(Math.abs(place[0]) / (width / 2 - margin), Math.abs(place[1]) / (height / 2 - margin));
  return excess > 1 ? { tip: scaled(1 / excess, place), angle: heading([0, 0], place) } : null;
}

// Positions along a branch of a curve: 0 is one end, 1 the other.
const SHARES = Array.from({ length: 301 }, (_, n) => n / 300);
for (let near = 1e-8; near < 0.5; near *= 1.04) SHARES.push(near, 1 - near);
SHARES.sort((a, b) => a - b);
