// Shapes in SVG. Points are [x, y] with y down. Angles are as the eye sees them: counter-clockwise.

import { abs, arg, conj, finite, minus, plus, scaled, turn } from "./complex.js";

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

// ---- The triangle of L, P and E, and its angles: in the diagram, and on the picture ----

// A part has the class q and the names of the quantities that it shows, as q-alpha.

const FAR = 4000;  // pixels
const MARGIN = 1.2;  // P is inside the drawing if it is so far from its edge, letters' heights

// P is null if it is infinitely far away. `rem` is the height of a letter, pixels.
export function triangle(L, E, P, { alpha, nu }, rem, box) {
  const base = line("base q q-L q-E q-M q-nu", L, E);
  if (!P) return [base];
  const near = abs(minus(P, L)) < FAR;
  const end = near ? P : step(L, heading(L, P), FAR);
  const parts = [base, ...vector("ray q q-r q-P q-alpha", L, end, rem), ...vector("ray of-nu q q-r q-nu q-M", end, E, rem)];
  parts.push(...angleAtE(L, E, end, nu, rem));
  const out = edge(P, box, MARGIN * rem);
  return [...parts, ...(out ? awayP(out, 1.1 * rem, rem) : angleAtP(L, E, P, alpha, rem))];
}

// An arrow to P, which is outside the drawing, and its name: `edge`.
export const awayP = ({ tip, angle }, length, rem) => [
  arrowhead("arrow q q-P", tip, angle, length), words("point q q-P", step(tip, angle + Math.PI, 1.9 * rem), "P"),
];

// The angle nu from the line to L to the line to P.
function angleAtE(L, E, P, nu, rem) {
  const radius = Math.min(3.2 * rem, 0.5 * abs(minus(P, E)), 0.8 * abs(minus(L, E)));
  if (!(Math.abs(nu) > 0.03) || radius < 0.6 * rem) return [];
  const start = heading(E, L);
  const beside = Math.abs(nu) * radius < 1.6 * rem;  // no room inside the arc
  const where = beside ? start - (Math.sign(nu) * 0.8 * rem) / radius : start + nu / 2;
  const name = words("of-nu q q-nu", step(E, where, radius + (beside ? 0 : 0.8 * rem)), "ν");
  return [arc("of-nu q q-nu", E, radius, start, nu), name];
}

// The angle alpha by which the light is turned, from the straight continuation of its path.
function angleAtP(L, E, P, alpha, rem) {
  const [before, after] = [heading(L, P), heading(P, E)];
  const bend = Math.min(1.9 * rem, 0.6 * abs(minus(P, E)), 0.6 * abs(minus(P, L)));
  if (Math.abs(alpha) < 0.03 || bend < 0.5 * rem) return [];
  const name = step(P, before + alpha / 2, bend + 0.8 * rem);
  return [
    line("straight q q-alpha", P, step(P, before, bend + 1.2 * rem)),
    arc("of-alpha q q-alpha", P, bend, before, after === before ? 0 : alpha),
    words("of-alpha q q-alpha", name, "α"),
  ];
}

// A corner's dot, and its name on the side away from the others, or if it is between them, beside their line.
export function corner(name, at, others, rem) {
  const towards = others.filter(Boolean).map((other) => turn(heading(at, other)));
  const sum = towards.reduce(plus, [0, 0]);
  const away = abs(sum) > 0.1 ? arg(sum) + Math.PI : arg(towards[0] ?? [1, 0]) - Math.PI / 2;
  return [dot(`dot q q-${name}`, at, 0.3 * rem, ""), words(`point q q-${name}`, step(at, away, 1.1 * rem), name)];
}

// The dots and names of L, E and P. P is left out if it is null or outside the drawing.
export const corners = (L, E, P, rem, box) => [
  ...corner("L", L, [E, P], rem), ...corner("E", E, [L, P], rem), ...(P && !edge(P, box, MARGIN * rem) ? corner("P", P, [L, E], rem) : []),
];
