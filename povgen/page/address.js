// The state in the page's address.

import { hasPiece } from "../liveview/presets.js";
import { pick } from "./data.js";
import { choose, LANGUAGES, spoken } from "./language.js";
import { MOST_CHOICES, QUESTIONS, revealed, setOwn } from "./questions.js";
import { change, CHOICES, inSeries, OPENING, partsShown, RANGES, session, START, state } from "./state.js";

const short = (x) => (x === "best" ? x : String(Number(x.toPrecision(7))));
export const SWITCHES = ["position", "circles", "image", "caption", "depth", "stray", "large"];

export function toHash() {
  const { scene, sheet, piece, question } = state;
  const parts = { scene, sheet };
  if (hasPiece(scene)) parts.piece = piece;
  for (const name of ["alpha", "z1", "z2", "prisms"]) parts[name] = short(state[name]);
  if (inSeries()) parts.sheet2 = state.sheet2;
  const own = [...(inSeries() ? ["windows", "d"] : []), ...partsShown()].filter((name) => name in RANGES);
  for (const name of own) parts[name] = [state[name]].flat().map(short).join(",");
  for (const name of ["L", "E"]) parts[name] = state[name].map(short).join(",");
  parts.show = SWITCHES.filter((name) => state[name]).join(",");
  parts.diagram = state.diagram;
  parts.light = state.light;
  if (state.light === "aim") parts.W = state.W.map(short).join(",");
  parts.level = state.level;
  if (state.compare !== "off") parts.compare = state.compare;
  /** @type {any} */
  const asked = QUESTIONS[question];
  if (asked?.own) parts.own = session.own_question;
  else if (asked) parts.question = asked.name;
  if (spoken.asked) parts.language = spoken.language;
  return `#${Object.entries(parts).map(([name, value]) => `${name}=${encodeURIComponent(value).replaceAll("%2C", ",")}`).join("&")}`;
}

// Take the values from an address. What is missing or wrong there has the value that the page opens with. A question whose
// answer has not been revealed is shown as before its answer.
export function fromHash(hash) {
  const given = new URLSearchParams(hash.slice(1));
  const values = valuesOf(given);
  if (LANGUAGES.includes(given.get("language"))) choose(given.get("language"), true);
  const question = given.has("own") ? own(given.get("own")) : QUESTIONS.findIndex(({ name }) => name === given.get("question"));
  if (QUESTIONS[question]) {
    Object.assign(values, { question }, revealed.has(question) ? {} : QUESTIONS[question].before);
    session.lastQuestion = question;
  }
  Object.assign(state, OPENING, START[values.scene ?? "chess"]);
  change(values);
  [session.replaced, session.own] = [null, {}];
}

// The number of a teacher's own question in an address; -1 if it is none.
function own(text) {
  if (text === session.own_question) return QUESTIONS.findIndex((/** @type {any} */ question) => question.own);
  try {
    const { ask, choices, why, before, after } = JSON.parse(text);
    const texts = [ask, why, before, after, ...choices];
    if (choices.length < 2 || choices.length > MOST_CHOICES || !ask || !texts.every((each) => typeof each === "string")) return -1;
    const [first, last] = [before, after].map((hash) => valuesOf(new URLSearchParams(hash.slice(1))));
    const then = last.sheet ? { ...pick(OPENING, "windows", "compare", "pupil", "focus"), ...last } : last;  // toHash leaves these out
    const opening = pick(OPENING, ...Object.keys(OPENING).filter((name) => name !== "question"));
    session.own_question = text;
    const n = setOwn({ ask, choices, why, before: { ...opening, ...START[first.scene ?? "chess"], ...first }, after: then });
    revealed.delete(n);
    return n;
  } catch {
    return -1;
  }
}

// The values in an address that are allowed.
function valuesOf(given) {
  const values = {};
  for (const [name, allowed] of Object.entries(CHOICES)) if (allowed.includes(given.get(name))) values[name] = given.get(name);
  for (const name of ["L", "E", "W", ...Object.keys(RANGES)]) {
    const parts = (given.get(name) ?? "").split(",");
    if (parts.length !== [OPENING[name]].flat().length || !parts.every(isNumber)) continue;
    values[name] = Array.isArray(OPENING[name]) ? parts.map(Number) : Number(parts[0]);
  }
  // a scene's angle may be up to 360 degrees: the same one here is from -180 to 180
  for (const name of ["alpha", "alpha2"]) if (Math.abs(values[name]) > 180) values[name] -= 360 * Math.round(values[name] / 360);
  if (given.has("show")) for (const name of SWITCHES) values[name] = given.get("show").split(",").includes(name);
  return values;
}
const isNumber = (text) => Boolean(text?.trim()) && Number.isFinite(Number(text));
