// Questions for a class: predict, then reveal. The page's equations compute every answer.

import { radians } from "../liveview/geometry.js";
import { fieldOf, imageDepth } from "./apparent.js";
import { minus, plus } from "./complex.js";
import { data, pick } from "./data.js";
import { mirrored } from "./equations.js";
import { inTab, work } from "./kept.js";
import { brief, briefly, entry, fixed, forms, say, SYMBOL, typedNumber } from "./language.js";
import { apparentPosition, moment } from "./moment.js";
import { bare, turnedBy } from "./phrases.js";
import { checksum } from "./scramble.js";
import { OPENING, session, START, state } from "./state.js";

// What a question can ask for, beside the settings (povgen/page/items.py): angles are in degrees.
export const QUANTITIES = {
  nu: ({ turned, nu }) => (turned ?? nu) / radians(1),
  far: () => quantityAt("nu", { z1: 1e9 }),  // the angle by which what is very far away appears turned
  M: ({ M }) => M,
  size: (now) => now.M / bare(now),  // compared with that without sheets
  image: ({ windows, z1 }) => -imageDepth(windows, z1),  // its distance in front of the window
  shift: (now) => minus(apparentPosition({ ...now, E: plus(now.E, [1, 0]) }), apparentPosition(now))[0],  // when the eye moves by 1
  height: ({ z1, z2 }) => mirrored([0, 1], [0, 0], z1, z2, { slab_shift: 0 })[1],  // through one sheet of infinitely fine prisms
  reach: ({ prism }) => prism.reach,  // how far a prism displaces light
  field: ({ scene }) => Math.atan(fieldOf(scene)) / radians(1),
  slope: ({ scene }) => fieldOf(scene),
};
const IN_DEGREES = ["nu", "far", "field"];

// What a function finds in the moment that the page shows with these settings.
export function found(values, find) {
  const kept = { ...state };
  Object.assign(state, values);
  try {
    return find(moment());
  } finally {
    Object.assign(state, kept);
  }
}
// A quantity of it, or one of the settings.
const quantityAt = (name, values) => (name in QUANTITIES ? found(values, QUANTITIES[name]) : values[name] ?? OPENING[name]);

// When a quantity is that of a question: before its answer, with it, from the one to the other, or without sheets.
const free = (values) => ({ ...values, sheet: "none", windows: 1 });
export const MOMENTS = {
  start: ({ before }, at) => at(before), end: (question, at) => at(end(question)),
  change: (question, at) => at(end(question)) - at(question.before), ratio: (question, at) => at(end(question)) / at(question.before),
  free_start: ({ before }, at) => at(free(before)), free_end: (question, at) => at(free(end(question))),
};
const computed = (question, when, name) => MOMENTS[when](question, (values) => quantityAt(name, values));

// Whether the picture grows over the window, as at the pole.
export const fillsWindow = (question) => computed(question, "end", "M") > 100;

// The same as texts, for words in braces as {end.nu}.
const textOf = (name, x) => (IN_DEGREES.includes(name) ? `${fixed(x, 1)}°` : name in SYMBOL ? briefly(name, x) : brief(name === "shift" ? Math.abs(x) : x));
const numbers = (question) => Object.fromEntries(Object.keys(MOMENTS).map((when) =>
  [when, new Proxy({}, { get: (_, name) => textOf(name, computed(question, when, name)) })]));

const isWithin = (x, least, most) => x >= least && x <= most;

// A question from its file: its name in the tables of sentences; what the page shows with it, and differently with the answer; the
// number of the right choice, or a number. `goal`: a challenge, which has no answer, but is done when this holds for what is seen.
// `match`: the settings that make the picture to be matched.
const FRESH = pick(OPENING, "scene", "sheet", "windows", "sheet2", "piece", "z1", "z2", "E", "L", "prisms", "pupil", "focus", "compare", ...Object.keys(data.parameters));
function questionOf({ start, end: after, answer, goal, match, ...given }) {
  /** @type {any} */
  const question = { ...given, before: { ...FRESH, ...START[start.scene], ...start }, after };
  if (match) question.match = pick(after, "alpha", "z1");
  if (goal) question.goal = () => Object.entries(goal).every(([name, [least, most]]) => isWithin(Math.abs(quantityAt(name, state)), least, most));
  question.answer = () => {
    if (typeof answer !== "string") return match ? question.match : choices(question) ? answer - 1 : answer;
    const [when, name] = answer.split("."), x = computed(question, when, name);
    return choices(question) ? 1 - Math.sign(Math.abs(x) < 1e-6 ? 0 : x) : x;
  };
  question.says = (now) => (entry(`questions.${given.name}.says`) ? say(`questions.${given.name}.says`, { ...numbers(question), turned: turnedBy(now.alpha, forms("mountains")) }) : "");
  return question;
}
/** @type {any[]} */
export const QUESTIONS = data.questions.map(questionOf);

// A teacher's own questions are behind the page's: { own, before, after }, where `own` has the texts, with the right choice first.
// The choices are shown in the order of the alphabet.
const COUNT = QUESTIONS.length;
export const MOST_CHOICES = 20;

// The question that comes first when the questions are opened again, also after the page was loaded again.
export function rememberQuestion(n) {
  session.lastQuestion = n;
  inTab("question", QUESTIONS[n].name);
}

export const nameOf = ({ ask, choices }) => `own-${checksum([ask, ...choices].join("\n")).toString(36)}`;
const ownOf = (question) => {
  const { choices } = question.own, shown = [...choices].sort((a, b) => a.localeCompare(b));
  return { ...question, name: nameOf(question.own), shown, answer: () => shown.indexOf(choices[0]) };
};
export const setOwn = (questions) => QUESTIONS.splice(COUNT, Infinity, ...questions.map(ownOf));
export const ownQuestions = () => QUESTIONS.slice(COUNT).map(({ own }) => own);
// The questions of which votes or answers are kept, also the own ones of other links.
export const worked = () => [...QUESTIONS, ...Object.entries(work.own).filter(([name]) => QUESTIONS.every((each) => each.name !== name)).map(([, own]) => ownOf({ own }))]
  .filter(({ name }) => work.votes[name] || work.answers[name]);
/** @type {(question: any) => string} */
export const ask = ({ name, own }) => own?.ask ?? say(`questions.${name}.ask`);

/** @type {(question: any) => string[]} */
export const choices = ({ name, shown }) => shown ?? entry(`questions.${name}.choices`);
/** @type {(question: any) => string} */
export const why = (question) => question.own?.why ?? ["why", ...(state.level === "expert" && entry(`questions.${question.name}.formula`) ? ["formula"] : [])]
  .map((part) => say(`questions.${question.name}.${part}`, numbers(question))).join(" ");

// What the page shows with the answer.
export const end = (question) => ({ ...question.before, ...question.after });

export function isRight(question, given) {
  if (question.match || question.goal) return given === "true";
  const near = question.tolerance * (1 + 1e-6);  // 2.1 - 2 is more than 0.1
  return choices(question) ? Number(given) === question.answer() : Math.abs(typedNumber(given).x - question.answer()) <= near;
}

// Why a wrong prediction is wrong: `wrong` has a sentence for each choice, for numbers that are too small and too large, or for a
// picture of another angle and of another size.
export function reason(question, given) {
  const said = entry(`questions.${question.name}.wrong`);
  return (given && !isRight(question, given) && said?.[choices(question) || question.match ? given : Number(typedNumber(given).x > question.answer())]) || "";
}

export const isRevealed = (n) => Boolean(work.answers[QUESTIONS[n].name]?.shown);
// The prediction for a question whose answer is shown.
export const prediction = (n) => (isRevealed(n) ? work.answers[QUESTIONS[n].name].given : null);
export const isAsked = () => state.question >= 0 && !isRevealed(state.question);
