// The choices beyond the paper: a second window, and ideal sheets that do not rotate light about their normal.

import { radians } from "../live/geometry.js";
import { pick } from "./data.js";
import { SETTINGS } from "./numbers.js";
import { change, OPENING, session, START, state } from "./state.js";

// What is chosen beside the paper's window, and the values with which it begins.
export const BEYOND = {
  none: { windows: 1, sheet: "ideal" },
  series: { windows: 2, sheet: "ideal", alpha: 120, alpha2: 120, d: 2, z1: 2, z2: 8 },
  axis: { windows: 1, sheet: "axis", alpha: 20, axis: [0, 1, 0], ...pick(OPENING, "z2") },
  refraction: { windows: 1, sheet: "refraction", alpha: 40, ratio: 0.7, ...pick(OPENING, "z2") },
  lenslets: { windows: 1, sheet: "lenslets", alpha: 180, ratio: 2, ...pick(OPENING, "z2") },
  mirror: { windows: 1, sheet: "mirror", alpha: 90, ...pick(OPENING, "z2") },
};
// The names of inputs that differ from those of the paper's window.
export const LABELS = {
  none: { alpha: "the light is turned by", z1: "object behind the window", z2: "eye in front of it", ratio: "" },
  series: { alpha: "the first window turns the light by", z1: "object behind the second window", z2: "eye in front of the first" },
  refraction: { ratio: "ratio of indices n₁/n₂: object’s side over eye’s" },
  lenslets: { ratio: "ratio of focal lengths f₁/f₂: object’s side over eye’s" },
  mirror: { alpha: "twice the angle of the mirror line" },
};
export const OTHER_SHEETS = ["axis", "refraction", "lenslets", "mirror"];

// Choose the paper's window, or what is beyond it. Each choice keeps its own values.
export function chooseBeyond(name) {
  session.own[chosenBeyond()] = pick(state, "windows", "sheet", "alpha", "alpha2", "d", "ratio", "axis", "z1", "z2");
  replace({ ...BEYOND[name], ...session.own[name] }, ["windows", "sheet"]);
}

export const chosenBeyond = () => (OTHER_SHEETS.includes(state.sheet) ? state.sheet : inSeries() ? "series" : "none");

// Whether there is a second window. One sheet of prisms, and the other sheets, are alone.
export const inSeries = () => state.windows === 2 && ["none", "detailed", "ideal"].includes(state.sheet);

// The distance from the second window to the first, and its angle in radians: [[distance, angle]]; [] without one.
export const behindFirst = ({ window, sheet }) => window.map(({ z, alpha }) => [z, sheet === "none" ? 0 : radians(alpha)]);

// ---- Settings that a movie, another choice or Reset replaces ----

// Change values, and keep what the user had set, for Undo. `chosen`: names of values that the user has chosen.
export function replace(values, chosen = []) {
  const before = { ...state };
  const usual = { ...OPENING, ...START[state.scene], ...BEYOND[chosenBeyond()] };
  change(values);
  const lost = Object.keys(SETTINGS).filter((name) =>
    !chosen.includes(name) && [state, usual].every((other) => String(other[name]) !== String(before[name])));
  if (lost.length && state.question < 0) session.replaced = { before, values: pick(state, ...lost) };
}

// The names of the settings that still have the values that replaced the user's own.
export const replacedNames = () => Object.entries(session.replaced?.values ?? {}).filter(([name, value]) => String(state[name]) === String(value)).map(([name]) => name);
