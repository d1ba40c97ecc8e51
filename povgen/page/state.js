// What the page shows. Lengths are in tiles, points are [x, y] as the eye sees them.

import * as geometry from "../liveview/geometry.js";
import { clamped, data, pick } from "./data.js";
import { say } from "./language.js";
import { brief, isAngle, SYMBOL } from "./numbers.js";

export const FLOOR = geometry.floorY(data.scenes.chess);
export const START = {
  chess: { L: [data.scenes.chess.x, FLOOR + data.scenes.chess.pedestal], z1: data.scenes.chess.z1 },
  spheres: { L: data.scenes.spheres.line, z1: data.scenes.spheres.z2 },
};
export const OPENING = {
  scene: "chess", sheet: "ideal", ...pick(data.scenes.chess, "z2", "prisms", "piece", ...Object.keys(data.parameters)),
  E: [0, 0], ...START.chess,
  windows: 1, sheet2: "same", alpha2: 120, d: 2,                 // beyond the paper: beyond.js
  position: false, circles: false, image: false, caption: false,  // what is drawn on the picture
  compare: "off",                                                // the sheets to the right of the curtain
  level: "simple",                                               // "expert" shows all controls
  light: "ray", stray: true, large: false,                        // the view of the light: which rays; in place of the picture
  W: [0.5, 0.5],                                                 // the point of the window through which a chosen ray passes
  diagram: "picture", question: -1,                              // the diagram's orientation; the question, or -1
};
export const RANGES = {
  ...Object.fromEntries(Object.entries(data.parameters).map(([name, { least, most }]) => [name, [least, most]])),
  z1: [0.01, 5000], z2: [0.01, 150], prisms: [1, data.limits.prisms], windows: [1, 2], d: [0.01, 100],
  alpha: [-180, 180], alpha2: [-180, 180],  // other angles turn light as one of these does
};
export const WHOLE = ["prisms", "windows", ...Object.keys(data.parameters).filter((name) => data.parameters[name].kind === "whole number")];
const SHEETS = ["none", "single", "detailed", "ideal", ...Object.keys(data.kinds)];
export const CHOICES = {
  scene: ["chess", "spheres"], sheet: SHEETS, sheet2: ["same", ...SHEETS].filter((name) => name !== "lenticular"), diagram: ["picture", "paper"], light: ["ray", "pencil", "eye", "aim", "prism", "field"], level: ["simple", "expert"], compare: ["off", "none", "single", "detailed", "ideal"], piece: data.pieces,
};
// povgen refuses ideal sheets behind prisms.
export const BEHIND_PRISMS = ["same", "single", "detailed"];
const ASIDE = 10;           // |x| and |y| of L and E are at most this
const LEAST_PEDESTAL = 0.2;
const IN_WINDOW = data.scenes.chess.aperture / 2 - 0.05;
export const state = { ...OPENING };

// What the page keeps beside the state. It is not in the address.
export const session = {
  refusals: [],       // sentences that say which values were not allowed in the last change
  replaced: null,     // all values before they were replaced, and the new values of those that were the user's own
  own: {},            // the user's own values of the choices beyond the paper that have been left
  explored: null,     // what the page showed before the questions
  lastQuestion: 0,
  own_question: "",   // a teacher's own question, as its address has it
  dashed: null,       // the dashed outline on the picture: its angle nu and its magnification M
  drawn: null,        // the outline that was drawn before the answer
  gliding: null,      // the values that the page is going to
  typing: null,       // the field that someone is typing in
  held: null,         // what is being dragged
  diagramMap: null,   // from the coordinates of the diagram that is shown to its pixels
  camera: [0.55, 0.3], // the view of the light: azimuth and elevation, radians
  measuring: false,   // whether the panel for measuring is open
  measured: false,    // whether a class has written down what it has measured
  curtain: 0.5,       // the part of the picture that is to the left of it
  zoom: 1,            // and its size
  marked: "",         // the quantity that is marked in the drawings
  pinned: "",         // the one that stays marked
};

// Change values of the state to the nearest allowed ones. Another scene begins with its own L and z1.
export function change(values) {
  const before = { ...state };
  if (values.scene && values.scene !== state.scene) values = { ...START[values.scene], ...values };
  Object.assign(state, values);
  session.refusals = [];
  /** @type {(name: string, x: number, range: number[], more?: { unit?: string, lower?: string }) => any} */
  const limited = (name, x, [least, most], { unit = "", lower = "least" } = {}) => {
    const kept = clamped(x, [least, most]);
    if (kept !== x) session.refusals.push(say(`limits.${x < least ? lower : "most"}`, { name, value: brief(kept) + unit }));
    return kept;
  };
  const component = (axis, name) => say("settings.x_of", { axis, name });
  for (const [name, range] of Object.entries(RANGES)) {
    if (Array.isArray(state[name])) state[name] = state[name].map((part, k) => limited(component("xyz"[k], SYMBOL[name]), part, range));
    else state[name] = limited(SYMBOL[name] ?? say(`settings.number_of_${name}`), state[name], range, isAngle(name) ? { unit: "°" } : {});
  }
  for (const name of WHOLE) {
    if (!Number.isInteger(state[name])) session.refusals.push(say("limits.whole", { name: SYMBOL[name] ?? say(`settings.number_of_${name}`) }));
    state[name] = Math.round(state[name]);
  }
  for (const [name, { size, kind }] of Object.entries(data.parameters)) {
    const most = Math.max(...[state[name]].flat().map(Math.abs));
    if (kind === "direction" && !(most > 0 && most >= size)) {
      session.refusals.push(say("limits.no_direction", { name: SYMBOL[name], values: state[name].join(", ") }));
      state[name] = before[name];
    } else if (most < size) {
      state[name] = (state[name] < 0 ? -1 : 1) * limited(`|${SYMBOL[name]}|`, most, [size, Infinity]);
    }
  }
  if (state.sheet === "lenticular") {  // a lens is at most a semicircle
    const { index } = data.scenes.chess, least = index / (2 * (index - 1) * Math.min(1, state.ratio));
    state.f_number = limited(SYMBOL.f_number, state.f_number, [least, Infinity]);
  }
  const { L, E } = state;
  const aside = [-ASIDE, ASIDE];
  // in the chess scene, a pedestal and the floor are below
  const heights = state.scene === "chess" ? [[FLOOR + LEAST_PEDESTAL, FLOOR + 10], [FLOOR + 0.05, ASIDE]] : [aside, aside];
  const below = state.scene === "chess" ? { lower: "floor" } : {};
  state.L = [limited(component("x", "L"), L[0], aside), limited(component("y", "L"), L[1], heights[0], below)];
  state.W = state.W.map((x) => clamped(x, [-IN_WINDOW, IN_WINDOW]));
  if (["single", "lenticular"].includes(state.sheet)) state.windows = 1;
  if (state.windows === 2 && state.sheet === "detailed" && !BEHIND_PRISMS.includes(state.sheet2)) {
    session.refusals.push(say("limits.behind_prisms"));
    state.sheet2 = "same";
  }
  state.E = [limited(component("x", "E"), E[0], aside), limited(component("y", "E"), E[1], heights[1], below)];
}
