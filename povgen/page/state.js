// What the page shows. Lengths are in tiles, points are [x, y] as the eye sees them.

import { frameFoot, hasPiece } from "../liveview/presets.js";
import { clamped, data, pick, wrapped } from "./data.js";
import { brief, entry, isAngle, say, SETTINGS, SYMBOL } from "./language.js";

export const FLOOR = frameFoot(data.scenes.chess);
export const START = {
  chess: { L: [data.scenes.chess.x, FLOOR + data.scenes.chess.pedestal], z1: data.scenes.chess.z1 },
  spheres: { L: data.scenes.spheres.line, z1: data.scenes.spheres.z2 },
};
export const OPENING = {
  scene: "chess", sheet: "ideal", ...pick(data.scenes.chess, "z2", "prisms", "piece", ...Object.keys(data.parameters)),
  E: [0, 0], ...START.chess,
  pupil: 0, focus: "best",                                       // the eye: as in povgen/scene/scene.py
  windows: 1, sheet2: "same", alpha2: 120, d: 2,                 // beyond the paper: BEYOND
  position: false, circles: false, image: false, caption: false,  // what is drawn on the picture
  depth: false,                                                  // whether the picture is for red and cyan glasses
  compare: "off",                                                // the sheets to the right of the curtain
  level: "simple",                                               // "expert" shows all controls
  light: "ray", stray: true, large: false,                        // the view of the light: which rays; in place of the picture
  W: [0.5, 0.5],                                                 // the point of the window through which a chosen ray passes
  diagram: "picture", question: -1,                              // the diagram's orientation; the question, or -1
};
export const RANGES = data.ranges;
export const CHOICES = { ...data.choices, piece: data.pieces };
export const SWITCHES = data.switches;
export const WHOLE = ["prisms", "windows", ...Object.keys(data.parameters).filter((name) => data.parameters[name].kind === "whole number")];
// povgen refuses ideal sheets behind prisms.
export const BEHIND_PRISMS = ["same", "single", "detailed"];
const ASIDE = 10;           // |x| and |y| of L and E are at most this
const LEAST_PEDESTAL = 0.2;
export const CAMERAS = { side: [0, 0], corner: [0.45, 0.55], above: [0, 1.5], eye: [1.57, 0.06] };  // azimuth and elevation, radians
const IN_WINDOW = data.scenes.chess.aperture / 2 - 0.05;
export const state = { ...OPENING };
export const LOOKER = ["level", "depth"];  // what depends on who looks: a question and the guided start leave it as it is

// What the page keeps beside the state. It is not in the address.
export const session = {
  refusals: [],       // sentences that say which values were not allowed in the last change
  replaced: null,     // all values before they were replaced, and the new values of those that were the user's own
  own: {},            // the user's own values of the choices beyond the paper that have been left
  explored: null,     // what the page showed before the questions
  lastQuestion: 0,
  own_questions: "",  // a teacher's own questions, as their address has them
  dashed: null,       // the dashed outline on the picture: its angle nu and its magnification M
  drawn: null,        // the outline that was drawn before the answer
  gliding: null,      // the values that the page is going to
  typing: null,       // the field that someone is typing in
  held: null,         // what is being dragged
  diagramMap: null,   // from the coordinates of the diagram that is shown to its pixels
  spaceView: null,    // from points in space to pixels of the light's view
  camera: CAMERAS.corner, // the view of the light
  measuring: false,   // whether the panel for measuring is open
  answered: false,    // whether the sentence is shown while a class measures
  curtain: 0.5,       // the part of the picture that is to the left of it
  zoom: 1,            // and its size
  floor: true,        // whether there is one: the user's own room can do without
  twin: 0,            // where the piece stands a second time: x, tiles; 0: nowhere
  room: "",           // a room in place of all this: an example's name, or its file, scrambled
  moved: {},          // the numbers of its eye and its windows that were changed, as "left.alpha"
  about: "",          // the number that the shown step of a lesson is about
  marked: "",         // the quantity that is marked in the drawings
  pinned: "",         // the one that stays marked
};

// Change values of the state to the nearest allowed ones. Another scene begins with its own L and z1.
export function change(values) {
  const before = { ...state };
  if (values.scene && values.scene !== state.scene) values = { ...START[values.scene], ...values };
  Object.assign(state, values);
  session.refusals = [];
  for (const name of ["alpha", "alpha2"]) state[name] = wrapped(state[name]);
  /** @type {(name: string, x: number, range: number[], more?: { unit?: string, lower?: string }) => any} */
  const limited = (name, x, [least, most], { unit = "", lower = "least" } = {}) => {
    const kept = clamped(x, [least, most]);
    if (kept !== x) session.refusals.push(say(`limits.${x < least ? lower : "most"}`, { name, value: brief(kept) + unit }));
    return kept;
  };
  const component = (axis, name) => say("settings.x_of", { axis, name });
  for (const [name, range] of Object.entries(RANGES)) {
    if (state[name] === "best") continue;
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
  const heights = hasPiece(state.scene) ? [[FLOOR + LEAST_PEDESTAL, FLOOR + 10], [FLOOR + 0.05, ASIDE]] : [aside, aside];
  const below = hasPiece(state.scene) ? { lower: "floor" } : {};
  state.L = [limited(component("x", "L"), L[0], aside), limited(component("y", "L"), L[1], heights[0], below)];
  state.W = state.W.map((x) => clamped(x, [-IN_WINDOW, IN_WINDOW]));
  if (["single", "lenticular"].includes(state.sheet)) state.windows = 1;
  if (state.windows === 2 && state.sheet === "detailed" && !BEHIND_PRISMS.includes(state.sheet2)) {
    session.refusals.push(say("limits.behind_prisms"));
    state.sheet2 = "same";
  }
  state.E = [limited(component("x", "E"), E[0], aside), limited(component("y", "E"), E[1], heights[1], below)];
}

// ---- The choices beyond the paper: a second window, and ideal sheets that do not rotate light about their normal ----

// What is chosen beside the paper's window, and the values with which it begins.
export const BEYOND = {
  none: { windows: 1, sheet: "ideal" },
  series: { windows: 2, sheet: "ideal", sheet2: "same", alpha: 120, alpha2: 120, d: 2, z1: 2, z2: 8 },
  ...Object.fromEntries(Object.entries(data.kinds).map(([sheet, { opening }]) => [sheet, { windows: 1, sheet, ...pick(OPENING, "z2"), ...opening }])),
};
// The labels of sliders that differ between the choices.
const turns = (window, n) => {
  const usual = say("controls.alpha"), label = entry(`kinds.${kinds()[n]}.labels`)?.alpha ?? usual;
  return label === usual ? say(`controls.alpha_${window}`) : say(`controls.label_${window}`, { label });
};
export const labels = (beyond) => ({
  ...Object.fromEntries(["alpha", "d", "z1", "z2", "prisms", "pupil", "focus", "L", "E"].map((name) => [name, say(`controls.${name}`)])),
  ...Object.assign({}, ...kinds().reverse().map((sheet) => pick(entry(`kinds.${sheet}.labels`) ?? {}, ...(data.kinds[sheet]?.parameters ?? [])))),
  ...(beyond === "series" ? { alpha: turns("first", 0), alpha2: turns("second", 1), z1: say("controls.z1_series"), z2: say("controls.z2_series") } : {}),
});

// Choose the paper's window, or what is beyond it. Each choice keeps its own values.
export function chooseBeyond(name) {
  session.own[chosenBeyond()] = pick(state, "windows", "sheet", "sheet2", "alpha2", "d", "z1", "z2", ...Object.keys(data.parameters));
  replace({ ...BEYOND[name], ...session.own[name] }, ["windows", "sheet", "sheet2"]);
}

// Choose the kind of the sheet in one of two windows: `name` is "sheet" or "sheet2". It begins with its own values.
export function chooseSheet(name, sheet) {
  const { opening = {}, parameters = [] } = data.kinds[sheet] ?? {};
  const { alpha, ...values } = pick(opening, ...parameters);
  if (alpha !== undefined && name === "sheet") values.alpha = alpha;
  if (alpha !== undefined && (name === "sheet2" || state.sheet2 === "same")) values.alpha2 = alpha;
  replace({ [name]: sheet, ...values }, [name]);
}

export const chosenBeyond = () => (inSeries() ? "series" : state.sheet in data.kinds ? state.sheet : "none");

export const usesAlpha = (sheet) => (data.kinds[sheet]?.parameters.includes("alpha") ?? (sheet === "ideal" || sheet === "detailed"));

// Whether there is a second window. One sheet of prisms is alone, and so are sheets of lenses.
export const inSeries = () => state.windows === 2 && !["single", "lenticular"].includes(state.sheet);

// The kinds of the sheets in the windows.
export const kinds = () => [state.sheet, ...(inSeries() ? [state.sheet2 === "same" ? state.sheet : state.sheet2] : [])];

export const isEmpty = () => kinds().every((sheet) => sheet === "none");

// Whether a sheet does something else than to rotate light about its normal. One sheet of prisms, alone, has equations of its own.
export const isGeneral = () => kinds().some((sheet, n, { length }) => sheet in data.kinds || (sheet === "single" && length > 1));

// What depends on the choice, among the parts of the page with the attribute `data-for`: the names of the parameters that the
// windows and an eye with a pupil use, "second" if there is a second window, and "none" (the paper's window), "series" (two windows that rotate light
// about their normal) or "general".
export function partsShown() {
  const used = kinds().map((sheet) => data.kinds[sheet]?.parameters ?? ["alpha"]);
  const second = inSeries() ? ["second", ...used[1].map((name) => (name === "alpha" ? "alpha2" : name))] : [];
  return [...used[0], ...second, ...(state.pupil ? ["pupil", "focus"] : []), isGeneral() ? "general" : inSeries() ? "series" : "none"];
}

// ---- Settings that a movie, another choice or Reset replaces ----

// Change values, and keep what the user had set, for Undo. `chosen`: names of values that the user has chosen.
export function replace(values, chosen = []) {
  const before = { ...state };
  const usual = { ...OPENING, ...START[state.scene], ...BEYOND[chosenBeyond()] };
  change(values);
  const lost = SETTINGS.filter((name) =>
    !chosen.includes(name) && [state, usual].every((other) => String(other[name]) !== String(before[name])));
  if (lost.length && state.question < 0) session.replaced = { before: pick(before, "scene", ...SETTINGS, ...Object.keys(values)), values: pick(state, ...lost) };
}

// Whether a setting still has the value that replaced the user's own.
export const isReplaced = () => Object.entries(session.replaced?.values ?? {}).some(([name, value]) => String(state[name]) === String(value));
