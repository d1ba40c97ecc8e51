// The choices beyond the paper: a second window, and ideal sheets that do not rotate light about their normal.

import { radians } from "../live/geometry.js";
import { data, pick } from "./data.js";
import { SETTINGS } from "./numbers.js";
import { change, OPENING, session, START, state } from "./state.js";

// What is chosen beside the paper's window, and the values with which it begins.
export const BEYOND = {
  none: { windows: 1, sheet: "ideal" },
  series: { windows: 2, sheet: "ideal", alpha: 120, alpha2: 120, d: 2, z1: 2, z2: 8 },
  ...Object.fromEntries(Object.entries(data.kinds).map(([sheet, { opening }]) => [sheet, { windows: 1, sheet, ...pick(OPENING, "z2"), ...opening }])),
};
// The labels of sliders that differ between the choices.
export const labels = (beyond) => ({
  alpha: data.parameters.alpha.label, z1: "object behind the window", z2: "eye in front of it",
  ...(beyond === "series" ? { alpha: "the first window turns the light by", z1: "object behind the second window", z2: "eye in front of the first" } : {}),
  ...data.kinds[beyond]?.parameters,
});

// Choose the paper's window, or what is beyond it. Each choice keeps its own values.
export function chooseBeyond(name) {
  session.own[chosenBeyond()] = pick(state, "windows", "sheet", "alpha2", "d", "z1", "z2", ...Object.keys(data.parameters));
  replace({ ...BEYOND[name], ...session.own[name] }, ["windows", "sheet"]);
}

export const chosenBeyond = () => (state.sheet in data.kinds ? state.sheet : inSeries() ? "series" : "none");

export const usesAlpha = (sheet) => (data.kinds[sheet] ? "alpha" in data.kinds[sheet].parameters : sheet === "ideal" || sheet === "detailed");

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
