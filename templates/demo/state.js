// What the page shows. Lengths are in tiles, points are [x, y] as the eye sees them.

import * as geometry from "../live/geometry.js";
import { clamped, data, pick } from "./data.js";
import { brief, isAngle, SYMBOL } from "./numbers.js";

export const FLOOR = geometry.floorY(data.scenes.chess);
export const START = {
  chess: { L: [data.scenes.chess.x, FLOOR + data.scenes.chess.pedestal], z1: data.scenes.chess.z1 },
  spheres: { L: data.scenes.spheres.line, z1: data.scenes.spheres.z2 },
};
export const OPENING = {
  scene: "chess", sheet: "ideal", ...pick(data.scenes.chess, "z2", "prisms", "piece", ...Object.keys(data.parameters)),
  E: [0, 0], ...START.chess,
  windows: 1, alpha2: 120, d: 2,                                 // beyond the paper: beyond.js
  position: false, circles: false, image: false, caption: false,  // what is drawn on the picture
  diagram: "picture", question: -1,                              // the diagram's orientation; the question, or -1
};
export const RANGES = {
  ...Object.fromEntries(Object.entries(data.parameters).map(([name, { least, most }]) => [name, [least, most]])),
  z1: [0.01, 5000], z2: [0.01, 150], prisms: [1, data.limits.prisms], windows: [1, 2], alpha2: [-360, 360], d: [0.01, 100],
};
export const WHOLE = ["prisms", "windows", ...Object.keys(data.parameters).filter((name) => data.parameters[name].kind === "whole number")];
export const CHOICES = {
  scene: ["chess", "spheres"], sheet: ["none", "single", "detailed", "ideal", ...Object.keys(data.kinds)], diagram: ["picture", "paper"], piece: data.pieces,
};
const ASIDE = 10;           // |x| and |y| of L and E are at most this
const LEAST_PEDESTAL = 0.2;
export const state = { ...OPENING };

// What the page keeps beside the state. It is not in the address.
export const session = {
  refusals: [],       // sentences that say which values were not allowed in the last change
  replaced: null,     // all values before they were replaced, and the new values of those that were the user's own
  own: {},            // the user's own values of the choices beyond the paper that have been left
  explored: null,     // what the page showed before the questions
  lastQuestion: 0,
  gliding: null,      // the values that the page is going to
  typing: null,       // the field that someone is typing in
  held: null,         // what is being dragged
  diagramMap: null,   // from the coordinates of the diagram that is shown to its pixels
  marked: "",         // the quantity that is marked in the drawings
  pinned: "",         // the one that stays marked
};

// Change values of the state to the nearest allowed ones. Another scene begins with its own L and z1.
export function change(values) {
  const before = { ...state };
  if (values.scene && values.scene !== state.scene) values = { ...START[values.scene], ...values };
  Object.assign(state, values);
  session.refusals = [];
  /** @type {(name: string, x: number, range: number[], why?: string) => any} */
  const limited = (name, x, [least, most], why = "") => {
    const kept = clamped(x, [least, most]);
    if (kept !== x) session.refusals.push(`${name} is at ${x < least ? "least" : "most"} ${brief(kept)}${why}.`);
    return kept;
  };
  for (const [name, range] of Object.entries(RANGES)) {
    if (Array.isArray(state[name])) state[name] = state[name].map((part, k) => limited(`${"xyz"[k]} of ${SYMBOL[name]}`, part, range));
    else state[name] = limited(SYMBOL[name], state[name], range, isAngle(name) ? "°" : "");
  }
  for (const name of WHOLE) {
    if (!Number.isInteger(state[name])) session.refusals.push(`${SYMBOL[name]} is a whole number.`);
    state[name] = Math.round(state[name]);
  }
  for (const [name, { size, kind }] of Object.entries(data.parameters)) {
    const most = Math.max(...[state[name]].flat().map(Math.abs));
    if (kind === "direction" && !(most > 0 && most >= size)) {
      session.refusals.push(`${SYMBOL[name]} = (${state[name].join(", ")}) has no direction: it stays as it was.`);
      state[name] = before[name];
    } else if (most < size) {
      state[name] = (state[name] < 0 ? -1 : 1) * limited(`|${SYMBOL[name]}|`, most, [size, Infinity]);
    }
  }
  const { L, E } = state;
  const aside = [-ASIDE, ASIDE];
  // in the chess scene, a pedestal and the floor are below
  const heights = state.scene === "chess" ? [[FLOOR + LEAST_PEDESTAL, FLOOR + 10], [FLOOR + 0.05, ASIDE]] : [aside, aside];
  /** @type {(y: number, range: number[]) => string} */
  const why = (y, [least]) => (state.scene === "chess" && y < least ? ": the floor is below" : "");
  state.L = [limited("x of L", L[0], aside), limited("y of L", L[1], heights[0], why(L[1], heights[0]))];
  if (state.sheet === "single") state.windows = 1;
  state.E = [limited("x of E", E[0], aside), limited("y of E", E[1], heights[1], why(E[1], heights[1]))];
}
