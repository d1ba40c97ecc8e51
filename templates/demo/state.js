// What the page shows. Lengths are in tiles, points are [x, y] as the eye sees them.

import * as geometry from "../live/geometry.js";
import { clamped, data } from "./data.js";
import { brief, SYMBOL } from "./numbers.js";


export const FLOOR = geometry.floorY(data.scenes.chess);
export const START = {
  chess: { L: [data.scenes.chess.x, FLOOR + data.scenes.chess.pedestal], z1: data.scenes.chess.z1 },
  spheres: { L: data.scenes.spheres.line, z1: data.scenes.spheres.z2 },
};
export const OPENING = {
  scene: "chess", sheet: "ideal", alpha: data.scenes.chess.alpha, z2: data.scenes.chess.z2, prisms: data.scenes.chess.prisms,
  piece: data.scenes.chess.piece, E: [0, 0], ...START.chess,
  windows: 1, alpha2: 120, d: 2, ratio: 0.7, axis: [0, 1, 0],    // beyond the paper: beyond.js
  position: false, circles: false, image: false, caption: false,  // what is drawn on the picture
  diagram: "picture", question: -1,                              // the diagram's orientation; the question, or -1
};
export const RANGES = {
  alpha: [-360, 360], z1: [0.01, 5000], z2: [0.01, 150], prisms: [1, data.limits.prisms],
  windows: [1, 2], alpha2: [-360, 360], d: [0.01, 100], ratio: [0.1, 10],
};
export const CHOICES = {
  scene: ["chess", "spheres"], sheet: ["none", "single", "detailed", "ideal", "axis", "refraction", "lenslets", "mirror"], diagram: ["picture", "paper"],
  piece: data.pieces,
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
  const { axis } = state;
  if (values.scene && values.scene !== state.scene) values = { ...START[values.scene], ...values };
  Object.assign(state, values);
  session.refusals = [];
  /** @type {(name: string, x: number, range: number[], why?: string) => number} */
  const limited = (name, x, [least, most], why = "") => {
    const kept = clamped(x, [least, most]);
    if (kept !== x) session.refusals.push(`${name} is at ${x < least ? "least" : "most"} ${brief(kept)}${name === SYMBOL.alpha || name === SYMBOL.alpha2 ? "°" : ""}${why}.`);
    return kept;
  };
  for (const [name, range] of Object.entries(RANGES)) state[name] = limited(SYMBOL[name], state[name], range);
  if (!Number.isInteger(state.prisms)) session.refusals.push("N is a whole number.");
  for (const name of ["prisms", "windows"]) state[name] = Math.round(state[name]);
  const { L, E } = state;
  const aside = [-ASIDE, ASIDE];
  // in the chess scene, a pedestal and the floor are below
  const heights = state.scene === "chess" ? [[FLOOR + LEAST_PEDESTAL, FLOOR + 10], [FLOOR + 0.05, ASIDE]] : [aside, aside];
  /** @type {(y: number, range: number[]) => string} */
  const why = (y, [least]) => (state.scene === "chess" && y < least ? ": the floor is below" : "");
  state.L = [limited("x of L", L[0], aside), limited("y of L", L[1], heights[0], why(L[1], heights[0]))];
  state.axis = state.axis.map((part, k) => limited(`${"xyz"[k]} of the axis`, part, [-1, 1]));
  if (!state.axis.some(Boolean)) {
    session.refusals.push("An axis of 0, 0, 0 has no direction: the axis stays as it was.");
    state.axis = axis;
  }
  if (state.sheet === "single") state.windows = 1;
  state.E = [limited("x of E", E[0], aside), limited("y of E", E[1], heights[1], why(E[1], heights[1]))];
}
