// The state in the page's address.

import { hasPiece } from "../liveview/presets.js";
import { pick } from "./data.js";
import { choose, LANGUAGES, say, spoken } from "./language.js";
import { end, isRevealed, MOST_CHOICES, ownQuestions, QUESTIONS, rememberQuestion, setOwn } from "./questions.js";
import { scrambled, unscrambled } from "./scramble.js";
import { CAMERAS, change, CHOICES, inSeries, LOOKER, OPENING, partsShown, RANGES, session, START, state, SWITCHES } from "./state.js";

const short = (x) => (x === "best" ? x : String(Number(x.toPrecision(7))));

// The settings, without the level, which is whose page it is.
export function settings() {
  const { scene, sheet, piece } = state;
  /** @type {Record<string, string>} */
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
  if (state.compare !== "off") parts.compare = state.compare;
  return parts;
}

// What stays for other settings, too. A teacher's own questions are last: the end is lost first where a link is cut.
export const lasting = () => ({
  level: state.level, ...(spoken.asked ? { language: spoken.language } : {}), ...(session.own_questions ? { own: session.own_questions } : {}),
});

export function toHash() {
  const asked = QUESTIONS[state.question];
  /** @type {Record<string, string>} */
  const parts = asked?.own ? {} : settings();  // a teacher's question has its own, and its link is short
  if (!asked?.own && viewed() !== "corner") parts.view = viewed();
  if (asked) parts.question = asked.name;
  else if (session.measuring) parts.panel = "measure";
  const moved = Object.entries(session.moved).map(([name, x]) => [name, short(x)]);
  return hashOf(session.room ? { room: session.room, ...Object.fromEntries(moved), ...parts } : parts);
}
const viewed = () => Object.keys(CAMERAS).find((name) => String(CAMERAS[name]) === String(session.camera)) ?? "corner";
const hashOf = (parts) => `#${Object.entries({ ...parts, ...lasting() }).map(([name, value]) => `${name}=${encodeURIComponent(value).replaceAll("%2C", ",")}`).join("&")}`;

// Take the values from an address. What is missing or wrong there has the value that the page opens with. A question whose
// answer has not been revealed is shown as before its answer, and what has been tried of a challenge as it was left; the others, if the
// address does not say more, as with it.
export function fromHash(hash) {
  const given = new URLSearchParams(hash.slice(1));
  let values = valuesOf(given);
  if (LANGUAGES.includes(given.get("language"))) choose(given.get("language"), true);
  const complete = takeOwn(given.get("own") ?? "");
  if (!QUESTIONS[session.lastQuestion]) session.lastQuestion = 0;
  const first = given.get("own")?.startsWith("{") ? ({ own }) => own : ({ name }) => name === given.get("question");
  const question = QUESTIONS.findIndex(first);
  if (QUESTIONS[question]) {
    const { before, goal, match } = QUESTIONS[question], revealed = isRevealed(question);
    values = revealed || goal || match ? { ...(revealed ? end(QUESTIONS[question]) : before), ...values, question } : { ...values, ...before, question };
    rememberQuestion(question);
  }
  Object.assign(state, OPENING, START[values.scene ?? "chess"]);
  change(values);
  if (!complete) session.refusals = [say("asking.own_cut")];
  session.camera = CAMERAS[given.get("view")] ?? CAMERAS.corner;
  session.room = given.get("room") ?? "";
  session.moved = Object.fromEntries([...given].filter(([name, x]) => name.includes(".") && isNumber(x)).map(([name, x]) => [name, Number(x)]));
  [session.replaced, session.own, session.drawn, session.measuring] = [null, {}, null, given.get("panel") === "measure"];
}

// ---- A teacher's own questions: { ask, choices, why, before, after }, with the right choice first. `before` says how the settings
// differ from those that the page opens with, and `after` how they differ from `before`. ----

const USUAL = settings();
const joined = (parts) => Object.entries(parts).map(([name, value]) => `${name}=${value}`).join("&");
const parted = (text) => Object.fromEntries(new URLSearchParams(text));
const differing = (from, to) => joined(pick({ ...Object.fromEntries(Object.keys(from).map((name) => [name, ""])), ...to }, ...Object.keys({ ...from, ...to }).filter((name) => from[name] !== to[name])));

// A question with the settings, as settings() returns them, before its answer and with it.
export const ownQuestion = (texts, first, last) => ({ ...texts, before: differing(USUAL, first), after: differing(first, last) });
export const coded = (questions) => (questions.length ? scrambled(JSON.stringify(questions.map(({ ask, why, before, after, choices }) => [ask, why, before, after, ...choices]))) : "");

// Take the questions of an address. Return whether it is complete.
function takeOwn(code) {
  if (code === session.own_questions) return true;
  setOwn([]);
  session.own_questions = "";
  try {
    if (code) setOwn(decoded(code));
    session.own_questions = coded(ownQuestions());  // an earlier version has written them in another way
    return true;
  } catch {
    return false;
  }
}

function decoded(code) {
  const found = code.startsWith("{") ? [JSON.parse(code)].map(({ ask, why, before, after, choices }) => [ask, why, ...[before, after].map((hash) => hash.slice(1)), ...choices]) : JSON.parse(unscrambled(code));
  return found.map((texts) => {
    const [ask, why, before, after, ...choices] = texts;
    if (choices.length < 2 || choices.length > MOST_CHOICES || !ask || !texts.every((each) => typeof each === "string")) throw new Error("no question");
    const all = [USUAL, parted(before), parted(after)];
    const [first, last] = [2, 3].map((count) => valuesOf(new URLSearchParams(Object.assign({}, ...all.slice(0, count)))));
    for (const name of LOOKER) [first, last].forEach((values) => delete values[name]);
    const opening = pick(OPENING, ...Object.keys(OPENING).filter((name) => !["question", ...LOOKER].includes(name)));
    return { own: { ask, why, before, after, choices }, before: { ...opening, ...START[first.scene], ...first }, after: { ...pick(OPENING, "windows", "compare", "pupil", "focus"), ...last } };
  });
}

// The values in an address that are allowed.
export function valuesOf(given) {
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
