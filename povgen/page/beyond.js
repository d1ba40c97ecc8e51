// The choices beyond the paper: a second window, and ideal sheets that do not rotate light about their normal.

import { data, pick } from "./data.js";
import { entry, say } from "./language.js";
import { SETTINGS } from "./numbers.js";
import { change, OPENING, session, START, state } from "./state.js";

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
  ...Object.fromEntries(["alpha", "d", "z1", "z2", "prisms", "L", "E"].map((name) => [name, say(`controls.${name}`)])),
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

// Whether a sheet does something else than to rotate light about its normal. One sheet of prisms, alone, has equations of its own.
export const isGeneral = () => kinds().some((sheet, n, { length }) => sheet in data.kinds || (sheet === "single" && length > 1));

// What depends on the choice, among the parts of the page with the attribute `data-for`: the names of the parameters that the
// windows use, "second" if there is a second window, and "none" (the paper's window), "series" (two windows that rotate light
// about their normal) or "general".
export function partsShown() {
  const used = kinds().map((sheet) => data.kinds[sheet]?.parameters ?? ["alpha"]);
  const second = inSeries() ? ["second", ...used[1].map((name) => (name === "alpha" ? "alpha2" : name))] : [];
  return [...used[0], ...second, isGeneral() ? "general" : inSeries() ? "series" : "none"];
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
