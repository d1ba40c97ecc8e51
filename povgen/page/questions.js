// Questions for a class: predict, then reveal. The page's equations compute every answer.

import { prism, radians } from "../liveview/geometry.js";
import { windows } from "../liveview/presets.js";
import { fieldOf, imageDepth } from "./apparent.js";
import { data } from "./data.js";
import * as equations from "./equations.js";
import { work } from "./kept.js";
import { brief, entry, fixed, forms, readNumber, say } from "./language.js";
import { bare, turnedBy } from "./phrases.js";
import { checksum } from "./scramble.js";
import { BEYOND, OPENING, START, state } from "./state.js";

const UP = {
  scene: "chess", sheet: "ideal", windows: 1, piece: "knight", alpha: 0, z1: 2, z2: 6, E: [0, 0], L: START.chess.L,
  prisms: OPENING.prisms, pupil: 0, compare: "off",
};
const ANGLES = [0, 15, 66];
const nuDegrees = (z1, z2, degrees) => equations.nu(z2 / z1, radians(degrees)) / radians(1);
const way = (x) => (Math.abs(x) < 0.5 ? 2 : x > 0 ? 0 : 1);
const degreesText = (x) => `${fixed(x, 1)}°`;

// The x between two others at which a growing function has a value.
function solved(f, value, low, high) {
  for (let n = 0; n < 80; n++) {
    const middle = (low + high) / 2;
    if (f(middle) < value) low = middle;
    else high = middle;
  }
  return (low + high) / 2;
}

// How far P moves when the eye moves by 1 to the right, tiles.
function parallax(z1, z2, degrees) {
  const [a, b] = [0, 1].map((x) => equations.position([0, -1], [x, 0], z1, z2, radians(degrees)));
  return b[0] - a[0];
}

// The alpha from 0 to 180 at which an object appears turned the most.
function mostTurned(z1, z2) {
  let best = 0;
  for (let k = 0; k <= 1800; k++) if (nuDegrees(z1, z2, k / 10) > nuDegrees(z1, z2, best)) best = k / 10;
  return best;
}

// The numbers that make the picture of "match"; and the sheets of lenses.
const MATCH = { alpha: 120, z1: 4 };
const LENSES = { lenses: 100, ratio: 1, f_number: 3, index: data.scenes.chess.index };
const fieldText = (values) => degreesText(Math.atan(fieldOf(values)) / radians(1));
// The magnification of heights by one infinitely fine sheet.
const heightOf = (z1, z2) => equations.mirrored([0, 1], [0, 0], z1, z2, { slab_shift: 0 })[1];
// From where what is at z1 = 2 is seen four times as large at 180 degrees as without sheets: (z2 + z1)/(z2 - z1) = 4.
const EYE = 10 / 3;
// How far in front of a lens of focal length 4 the image of what is at z1 is.
const imageAt = (z1) => -imageDepth(windows({ ...data.scenes.chess, sheet: "lens", focal_length: 4, window: [] }), z1);

// Each: its name in the tables of sentences, where `choices`, `unit` and `why` are; what the page shows with it; the number of the
// right choice, or a number; what the page then shows; the numbers in `why`, and in `formula`, which only
// experts read; and what the sentence beside the picture says first. `expert`: only experts are asked. `goal`: a challenge, which
// has no answer, but is done when this holds for what is seen.
/** @type {any[]} */
export const QUESTIONS = [
  {
    name: "sky",
    before: { ...UP, sheet: "none" }, after: { sheet: "single" },
    answer: () => (equations.mirrored([0, 100], [0, 0], 1e4, 6, { slab_shift: 0 })[1] < 0 ? 2 : 0),
  },
  {
    name: "near",
    before: UP, after: { alpha: 66 }, ways: true,
    answer: () => way(nuDegrees(2, 6, 66)),
    numbers: () => ({ nu: degreesText(nuDegrees(2, 6, 66)) }),
  },
  {
    name: "far",
    before: { ...UP, alpha: 0 }, after: { alpha: 66 },
    degrees: ANGLES,
    answer: () => ANGLES.map((x) => Math.abs(nuDegrees(1e9, 6, 66) - x)).reduce((best, gap, k, gaps) => (gap < gaps[best] ? k : best), 0),
    says: ({ alpha }) => say("questions.far.says", { turned: turnedBy(alpha, forms("mountains")) }),
  },
  {
    name: "away",
    before: { ...UP, alpha: 90 }, after: { z1: 12 },
    answer: () => (nuDegrees(12, 6, 90) > nuDegrees(2, 6, 90) + 0.1 ? 0 : 2),
    numbers: () => ({ from: degreesText(nuDegrees(2, 6, 90)), to: degreesText(nuDegrees(12, 6, 90)) }),
  },
  {
    name: "half", expert: true,
    before: { ...UP, alpha: 90 }, tolerance: 0.1,
    answer: () => solved((z1) => nuDegrees(z1, 6, 90), 45, 0.1, 1000),
    after() { return { z1: this.answer() }; },
  },
  {
    name: "upright",
    before: UP, tolerance: 0.1, after: { alpha: 180 },
    answer: () => equations.M(3, Math.PI) / equations.M(3, 0),
    numbers: () => ({ after: brief(equations.M(3, Math.PI)), before: brief(equations.M(3, 0)) }),
  },
  {
    name: "parallax",
    before: { ...UP, alpha: 180 }, after: { E: [0.8, 0] },
    answer: () => (parallax(2, 6, 180) > 0 ? 0 : 2),
    numbers: () => ({ left: brief(-parallax(2, 6, 180)), right: brief(parallax(2, 6, 0)) }),
  },
  {
    name: "most",
    before: UP, tolerance: 5,
    after() { return { alpha: this.answer() }; },
    answer: () => mostTurned(2, 6),
    numbers: () => ({ nu: degreesText(nuDegrees(2, 6, mostTurned(2, 6))) }),
  },
  {
    name: "pole",
    before: { ...UP, alpha: 180 }, after: { z1: 6 },
    answer: () => (Number.isFinite(equations.M(1, Math.PI)) ? 1 : 2),
  },
  {
    name: "prisms", expert: true,
    before: { ...UP, sheet: "detailed", alpha: 66, prisms: 100 }, after: { prisms: 20 }, tolerance: 0.2,
    answer: () => prism({ ...data.scenes.chess, prisms: 20 }).reach / prism({ ...data.scenes.chess, prisms: 100 }).reach,
  },
  {
    name: "single",
    before: { ...UP, sheet: "single", z2: 4 }, after: { z1: 8 },
    answer: () => (heightOf(8, 4) < 0 ? 1 : 0),
    numbers: () => ({ height: brief(heightOf(8, 4)) }),
  },
  {
    name: "circles", expert: true,
    before: { ...UP, alpha: 60, z1: 6, diagram: "paper", circles: true }, after: { position: true }, tolerance: 2,
    answer: () => nuDegrees(6, 6, 60),
  },
  {
    name: "negative",
    before: { ...UP, alpha: 66 }, after: { alpha: -66 },
    answer: () => {
      const same = Math.abs(equations.M(3, radians(-66)) - equations.M(3, radians(66))) < 1e-9;
      return nuDegrees(2, 6, -66) * nuDegrees(2, 6, 66) > 0 ? 2 : same ? 0 : 1;
    },
    numbers: () => ({ before: degreesText(nuDegrees(2, 6, 66)), after: degreesText(nuDegrees(2, 6, -66)) }),
  },
  {
    name: "nearer",
    before: { ...UP, alpha: 180 }, after: { z2: 3 },
    answer: () => 1 - Math.sign(equations.M(3 / 2, Math.PI) - equations.M(6 / 2, Math.PI)),
    numbers: () => ({
      before: brief(equations.M(3, Math.PI)), after: brief(equations.M(1.5, Math.PI)),
      free_before: brief(equations.M(3, 0)), free_after: brief(equations.M(1.5, 0)),
    }),
  },
  {
    name: "match", expert: true,
    before: { ...UP, alpha: 40 }, after: { ...MATCH }, match: MATCH,
    answer: () => MATCH,
    numbers: () => ({ alpha: `${fixed(MATCH.alpha, 0)}°`, z1: brief(MATCH.z1) }),
  },
  {
    name: "law", expert: true,
    before: { ...UP, sheet: "none", z1: 8, z2: 12 }, after: { sheet: "lens", focal_length: 4, E: [0.3, 0] }, tolerance: 0.2,
    answer: () => imageAt(8),
    numbers: () => ({ b: brief(imageAt(8)) }),
  },
  {
    name: "tolerance",
    before: { ...UP, alpha: 66 }, after: { alpha: 68 }, tolerance: 0.1,
    answer: () => nuDegrees(1e9, 6, 66 + 2 * 1) - nuDegrees(1e9, 6, 66),
    numbers: () => ({ near: degreesText(nuDegrees(2, 6, 68) - nuDegrees(2, 6, 66)) }),
  },
  {
    name: "lenses", expert: true,
    before: { ...UP, sheet: "detailed", alpha: 66 }, after: { ...LENSES, sheet: "lenticular" }, tolerance: 0.5,
    answer: () => Math.atan(fieldOf(LENSES)) / radians(1),
    numbers: () => ({ depth: brief((1 + LENSES.ratio) * LENSES.f_number), slope: brief(fieldOf(LENSES)) }),
  },
  {
    name: "slower", expert: true,
    before: { ...UP, ...LENSES, sheet: "lenticular", alpha: 66 }, after: { f_number: 6 },
    answer: () => 1 + Math.sign(fieldOf(LENSES) - fieldOf({ ...LENSES, f_number: 6 })),
    numbers: () => ({ before: fieldText(LENSES), after: fieldText({ ...LENSES, f_number: 6 }) }),
  },
  {
    name: "series", expert: true,
    before: { ...UP, ...BEYOND.series }, tolerance: 0.1, after: { E: [0.8, 0] },
    answer: () => 8 - equations.depth(2, 8, radians(120), [[2, radians(120)]])[0],
  },
  {
    name: "quarter",
    before: { ...UP, alpha: 66 }, after: { alpha: 120, z1: 12 },
    goal: ({ nu }) => Math.abs(Math.abs(nu) - radians(90)) < radians(3),
  },
  {
    name: "again",
    before: { ...UP, alpha: 66 }, after: { alpha: 180 },
    goal: (now) => Math.abs(now.nu) < radians(3) && now.M / bare(now) > 1.5,
  },
  {
    name: "where",
    before: { ...UP, alpha: 180 }, after: { z2: EYE },
    goal: (now) => Math.abs(now.degrees) > 179 && Math.abs(now.z1 - 2) < 0.01 && Math.abs(now.M / bare(now) - 4) < 0.3,
    numbers: () => ({ z2: brief(EYE) }),
  },
];

// The choices of a question, or undefined if a number is asked for; and why its answer is right.
// A teacher's own questions are behind the page's: { own, before, after }, where `own` has the texts, with the right choice first.
// The choices are shown in the order of the alphabet.
const COUNT = QUESTIONS.length;
export const MOST_CHOICES = 20;
export const nameOf = ({ ask, choices }) => `own-${checksum([ask, ...choices].join("\n")).toString(36)}`;
export function setOwn(questions) {
  QUESTIONS.splice(COUNT, Infinity, ...questions.map((question) => {
    const { choices } = question.own, shown = [...choices].sort((a, b) => a.localeCompare(b));
    return { ...question, name: nameOf(question.own), shown, answer: () => shown.indexOf(choices[0]) };
  }));
}
export const ownQuestions = () => QUESTIONS.slice(COUNT).map(({ own }) => own);
/** @type {(question: any) => string} */
export const ask = ({ name, own }) => own?.ask ?? say(`questions.${name}.ask`);

/** @type {(question: any) => string[]} */
export const choices = ({ name, ways, degrees, shown }) => shown ?? degrees?.map((x) => `${x}°`) ?? entry(ways ? "asking.ways" : `questions.${name}.choices`);
/** @type {(question: any) => string} */
export const why = ({ name, numbers, own }) => own?.why ?? ["why", ...(state.level === "expert" && entry(`questions.${name}.formula`) ? ["formula"] : [])]
  .map((part) => say(`questions.${name}.${part}`, numbers?.())).join(" ");

// What the page shows with the answer.
export const end = (question) => ({ ...question.before, ...(typeof question.after === "function" ? question.after() : question.after) });

export function isRight(question, given) {
  if (question.match || question.goal) return given === "true";
  const near = question.tolerance * (1 + 1e-6);  // 2.1 - 2 is more than 0.1
  return choices(question) ? Number(given) === question.answer() : Math.abs(readNumber(given) - question.answer()) <= near;
}

// Why a wrong prediction is wrong: `wrong` has a sentence for each choice, or for numbers that are too small and too large.
export function reason(question, given) {
  const said = entry(`questions.${question.name}.wrong`);
  return (given && !isRight(question, given) && said?.[choices(question) ? given : Number(readNumber(given) > question.answer())]) || "";
}

export const isRevealed = (n) => Boolean(work.answers[QUESTIONS[n].name]?.shown);
// The prediction for a question whose answer is shown.
export const prediction = (n) => (isRevealed(n) ? work.answers[QUESTIONS[n].name].given : null);
export const isAsked = () => state.question >= 0 && !isRevealed(state.question);
