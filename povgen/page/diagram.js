// The diagram: figure 5(b) and (c) of the paper. It has the paper's orientation, with L = 0 and E = 1, or the picture's.

import { radians } from "../liveview/geometry.js";
import { abs, arg, conj, finite, minus, plus, scaled, times, turn } from "./complex.js";
import { $, clamped } from "./data.js";
import * as equations from "./equations.js";
import { angle, fixed, point, say, size } from "./language.js";
import { branches, corner, corners, curve, dot, heading, line, step, svg, triangle, vector, words } from "./shapes.js";
import { isGeneral, session, state } from "./state.js";

const diagram = $("diagram");

export const orientation = () => (isGeneral() ? "picture" : state.diagram);

// From the paper's coordinates and from the picture's tiles to pixels of the diagram.
function mapOf({ width, height }, rem, { L, E, P, two }) {
  const D = minus(E, L);
  const distance = Math.max(abs(D), 0.02);
  // the middle is midway between L and E, and a little on P's side
  const middle = [0.5, finite(P) ? clamped(0.5 * P[1], [-0.25, 0.25]) : 0];
  const unit = Math.min(width / 2.2, height / (two ? 1.75 : 2.7), height - 3.4 * rem);  // with room for the names
  if (orientation() === "paper") {
    const at = (p) => times([unit, 0], conj(minus(p, middle)));
    return { at, unit, turned: 0 };
  }
  const tile = unit / distance;
  const centre = plus(L, times(D, middle));
  const ofTiles = ([x, y]) => [tile * (x - centre[0]), tile * (centre[1] - y)];
  const at = (p) => ofTiles(plus(L, times(D, p)));
  return { at, unit: tile * abs(D), turned: arg(D), tile, ofTiles };
}

export function drawDiagram(now) {
  const { width, height } = diagram.getBoundingClientRect(), box = { width, height };
  if (!width) return;
  const rem = 0.9 * parseFloat(getComputedStyle(document.documentElement).fontSize);
  const isDepth = now.Z && orientation() === "paper", map = isDepth ? null : session.held?.map ?? mapOf(box, rem, now);
  session.diagramMap = map;
  diagram.setAttribute("viewBox", `${-width / 2} ${-height / 2} ${width} ${height}`);
  diagram.replaceChildren(...(isDepth ? depthDiagram(now, box, rem) : triangleDiagram(now, map, box, rem)));
  diagram.setAttribute("aria-label", diagramName(now));
}

function triangleDiagram(now, map, box, rem) {
  const { at } = map, [L, E] = [at([0, 0]), at([1, 0])], { two } = now;
  const place = two ? finite(now.P) && at(scaled(Math.min(1, 1e4 / abs(now.P)), now.P)) : map.ofTiles?.(now.place);
  const P = place && finite(place) ? place : null, angles = two ? { alpha: now.alpha, nu: equations.nu(now.r, now.alpha) } : { alpha: 0, nu: 0 };
  return [
    ...(map.ofTiles ? windowOutline(map, now) : axes(at, box, rem)),
    ...(two ? [...family(map, box), ...curves(map, now), ...(map.ofTiles ? [] : scaleNames(at, now, rem))] : []),
    ...(P && abs(minus(L, E)) >= 1 ? triangle(L, E, P, angles, rem, box) : []),
    ...(two && P ? others(map, now, rem) : []), ...corners(L, E, P, rem, box),
  ];
}

function diagramName(now) {
  if (now.Z && orientation() === "paper") return say("diagram.depth", { Z: point(now.Z) });
  if (!now.two) return say("diagram.points");
  if (abs(minus(now.L, now.E)) < 1e-9) return say("diagram.same");
  const P = finite(now.P) ? point(now.P) : say("diagram.infinite");
  const nu = angle(equations.nu(now.r, now.alpha));
  return say("diagram.triangle", { P, alpha: `${fixed(now.degrees, 1)}°`, nu, r: size(now.r) });
}

function windowOutline({ ofTiles, tile }, { scene }) {
  const half = scene.aperture / 2;
  const [x, y] = ofTiles([-half, half]);
  return [svg("rect", { class: "window", x, y, width: 2 * half * tile, height: 2 * half * tile })];
}

function axes(at, { width, height }, rem) {
  const L = at([0, 0]);
  return [
    line("axis", [-width, L[1]], [width, L[1]]), line("axis", [L[0], -height], [L[0], height]),
    words("scale", [width / 2 - 0.8 * rem, L[1] + 0.9 * rem], "ξ"), words("scale", [L[0] - 0.8 * rem, 0.9 * rem - height / 2], "ψ"),
  ];
}

/** @type {[number, string][]} */
const FAMILY_R = [[1 / 4, "¼"], [1 / 2, "½"], [2, "r = 2"], [4, "4"]];

// The circles of constant alpha (through L and E) and of constant r (around L or E).
function family({ at, unit, turned }, { width, height }) {
  const reach = width + height;
  const middle = at([0.5, 0]);
  const parts = [line("family", step(middle, turned + Math.PI / 2, reach), step(middle, turned - Math.PI / 2, reach))];
  for (const [r] of FAMILY_R) {
    parts.push(dot("family", at([-1 / (r * r - 1), 0]), (unit * r) / Math.abs(r * r - 1)));
  }
  for (const degrees of [30, 60, 90, 120, 150]) {
    const alpha = radians(degrees);
    for (const side of degrees === 90 ? [1] : [1, -1]) {
      if (degrees <= 90) parts.push(dot("family", at([0.5, (0.5 * side) / Math.tan(alpha)]), (0.5 * unit) / Math.sin(alpha)));
    }
  }
  return parts;
}

// The names of the circles. A name is left out if it would cover another, or a corner of the triangle.
function scaleNames(at, { alpha, P }, rem) {
  const sign = alpha < 0 ? -1 : 1;
  const names = [];
  const taken = [[0, 0], [1, 0], ...(finite(P) ? [P] : [])].map((corner) => [...at(corner), rem]);
  const name = (place, text) => {
    const half = 0.25 * rem * text.length + 0.2 * rem;
    const apart = ([x, y, other]) => Math.abs(x - place[0]) > half + other || Math.abs(y - place[1]) > 1.1 * rem;
    if (!taken.every(apart)) return;
    taken.push([...place, half]);
    names.push(words("scale", place, text));
  };
  name(at([0.5, 0.46 * sign]), "r = 1");
  for (const [r, text] of FAMILY_R) {
    const [centre, radius] = [-1 / (r * r - 1), r / Math.abs(r * r - 1)];
    name(at([centre, radius < 0.5 ? sign * radius : -sign * radius]), text);
  }
  for (const degrees of [90, 60, 30]) {
    const text = `${degrees === 90 ? "α = " : ""}${sign < 0 ? "−" : ""}${degrees}°`;
    name(at([0.5, -0.5 * sign * Math.tan(radians(degrees) / 2)]), text);
  }
  return names;
}

const curves = ({ at }, now) => [
  curve("of-alpha q q-z1 q-z2", branches((log) => at(equations.P(Math.exp(log), now.alpha)), -8, 8, [0])),
  curve("of-r q q-r q-alpha", branches((alpha) => at(equations.P(now.r, alpha)), -Math.PI, Math.PI)),
];

// P of the other objects.
function others({ at }, now, rem) {
  if (now.objects.length < 2) return [];
  const places = now.objects.map((z1) => equations.P(now.z2 / z1, now.alpha)).filter(finite);
  return places.map((P) => dot("other", at(P), 0.22 * rem));
}

// ---- The diagram of the complex depth: Z = z2 + d e^(-i alpha) + z1 e^(-i(alpha + alpha2)), step by step ----

function depthDiagram({ z1, z2, alpha, total, d }, { width, height }, rem) {
  const steps = [
    ["z₂", [z2, 0], "of-r q-z2"], ["d", scaled(d, turn(-alpha)), "of-alpha q-d q-alpha"],
    ["z₁", scaled(z1, turn(-total)), "of-nu q-z1 q-alpha2"],
  ];
  const ends = steps.reduce((points, [, step]) => [...points, plus(points.at(-1), step)], [[0, 0]]);
  const [low, high] = [Math.min, Math.max].map((most) => [0, 1].map((k) => most(...ends.map((end) => end[k]))));
  // the switch is at the left, or above
  const [left, above] = width > 24 * rem ? [9 * rem, 0] : [0, 3.6 * rem];
  const unit = Math.min((width - left - 9 * rem) / Math.max(high[0] - low[0], 0.1), (height - above - 4 * rem) / Math.max(high[1] - low[1], 0.1));
  const middle = scaled(0.5, plus(low, high));
  /** @type {(z: number[]) => any} */
  const at = (z) => [left / 2 - 1.5 * rem + unit * (z[0] - middle[0]), above / 2 + unit * (middle[1] - z[1])];
  const [O, , , Z] = ends.map(at), centre = at(middle);
  const parts = [
    line("axis", [left - width / 2, O[1]], [width, O[1]]), words("scale", [width / 2 - 2 * rem, O[1] + 0.8 * rem], say("diagram.real_axis")),
    line("base q q-Z q-nu q-M q-P", O, Z), dot("dot", O, 0.2 * rem), words("scale", plus(O, [-0.8 * rem, 0]), "0"),
  ];
  steps.forEach(([name, , kind], k) => {
    const [from, to] = [at(ends[k]), at(ends[k + 1])];
    parts.push(...vector(`ray q ${kind}`, from, to, rem));
    if (abs(minus(to, from)) < 1.5 * rem) return;
    const half = scaled(0.5, plus(from, to));
    const sides = [1, -1].map((side) => step(half, heading(from, to) + (side * Math.PI) / 2, 0.9 * rem));
    sides.sort((a, b) => abs(minus(b, centre)) - abs(minus(a, centre)));  // outside
    parts.push(words(`point q ${kind}`, sides[0], name));
  });
  return [...parts, ...corner("Z", Z, [at(ends[2])], rem)];
}
