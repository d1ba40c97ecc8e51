// The triangle of L, P and E, and its angles: in the diagram, and on the picture. Points are in pixels, y down.
//
// A part has the class q and the names of the quantities that it shows, as q-alpha.

import { abs, arg, minus, plus, turn } from "./complex.js";
import { arc, arrowhead, dot, edge, heading, line, step, vector, words } from "./shapes.js";

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
