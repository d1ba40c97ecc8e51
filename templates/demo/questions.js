// Questions for a class: predict, then reveal. The page's equations compute every answer.

import { radians } from "../live/geometry.js";
import { BEYOND } from "./beyond.js";
import * as equations from "./equations.js";
import { brief, fixed } from "./numbers.js";
import { turnedBy } from "./phrases.js";
import { START, state } from "./state.js";

const UP = { scene: "chess", sheet: "ideal", windows: 1, piece: "knight", alpha: 0, z1: 2, z2: 6, E: [0, 0], L: START.chess.L };
const WAYS = ["counter-clockwise", "clockwise", "it does not turn"];
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
  const [a, b] = [0, 1].map((x) => equations.ideal([0, -1], [x, 0], z1, z2, radians(degrees)));
  return b[0] - a[0];
}

// The alpha from 0 to 180 at which an object appears turned the most.
function mostTurned(z1, z2) {
  let best = 0;
  for (let k = 0; k <= 1800; k++) if (nuDegrees(z1, z2, k / 10) > nuDegrees(z1, z2, best)) best = k / 10;
  return best;
}

// Each: the question; what the page shows with it; the choices and the number of the right one, or a number; what the page
// then shows; why; and what the sentence beside the picture says first.
export const QUESTIONS = [
  {
    ask: "A single sheet of prisms is put into the window. What happens to the sky and the floor?",
    before: { ...UP, sheet: "none" }, after: { sheet: "single" },
    choices: ["they stay", "they turn by a quarter", "they change places"],
    answer: () => (equations.mirrored([0, 100], [0, 0], 1e4, 6, { slab_shift: 0 })[1] < 0 ? 2 : 0),
    why: () => "A sheet reverses the light's slope across its prisms, and leaves the slope along them. Two sheets mirror twice: that is a rotation.",
  },
  {
    ask: "Two sheets turn the light counter-clockwise by α = 66° on its way to the eye. Which way does the knight turn?",
    before: UP, after: { alpha: 66 }, choices: WAYS,
    answer: () => way(nuDegrees(2, 6, 66)),
    why: () => `It turns by ν = ${degreesText(nuDegrees(2, 6, 66))} only, because it is near the sheets: z₁ is a third of z₂.`,
  },
  {
    ask: "And the mountains, which are very far away? By which angle do they turn at α = 66°?",
    before: { ...UP, alpha: 0 }, after: { alpha: 66 }, choices: ["0°", "15°", "66°"],
    answer: () => [0, 15, 66].map((x) => Math.abs(nuDegrees(1e9, 6, 66) - x)).reduce((best, gap, k, gaps) => (gap < gaps[best] ? k : best), 0),
    why: () => "Far away, r = z₂/z₁ tends to 0, and ν to α: the light comes from one direction, which the sheets turn by α.",
    says: ({ alpha }) => `The mountains appear ${turnedBy(alpha)}.`,
  },
  {
    ask: "At α = 90° the knight moves away, from z₁ = 2 to 12 tiles. What happens to its angle?",
    before: { ...UP, alpha: 90 }, after: { z1: 12 }, choices: ["it turns further", "the angle stays", "it turns back"],
    answer: () => (nuDegrees(12, 6, 90) > nuDegrees(2, 6, 90) + 0.1 ? 0 : 2),
    why: () => `ν = arctan(z₁/z₂) at α = 90°: it grows from ${degreesText(nuDegrees(2, 6, 90))} to ${degreesText(nuDegrees(12, 6, 90))}.`,
  },
  {
    ask: "At α = 90° and z₂ = 6, where must the knight stand to appear turned by 45°?",
    before: { ...UP, alpha: 90 }, unit: "tiles behind the sheets (z₁)", tolerance: 0.1,
    answer: () => solved((z1) => nuDegrees(z1, 6, 90), 45, 0.1, 1000),
    after: () => ({ z1: QUESTIONS[4].answer() }),
    why: () => "As far behind the sheets as the eye is in front of them: 1 − P = 1/(1 − i z₁/z₂) has the angle 45° for z₁ = z₂.",
  },
  {
    ask: "At α = 180° the knight is upright again. How many times as large as at α = 0 does it appear?",
    before: UP, unit: "times", tolerance: 0.1, after: { alpha: 180 },
    answer: () => equations.M(3, Math.PI) / equations.M(3, 0),
    why: () => `M = z₂/(z₂ − z₁) = ${brief(equations.M(3, Math.PI))} instead of z₂/(z₂ + z₁) = ${brief(equations.M(3, 0))}: its image is nearer to the eye than the window.`,
  },
  {
    ask: "At α = 180° you move your eye to the right. Which way does the knight move in the window?",
    before: { ...UP, alpha: 180 }, after: { E: [0.8, 0] }, choices: ["to the right", "it stays", "to the left"],
    answer: () => (parallax(2, 6, 180) > 0 ? 0 : 2),
    why: () => `To the left, by ${brief(-parallax(2, 6, 180))} of your step; without sheets, to the right by ${brief(parallax(2, 6, 0))}. So the image floats in front of the window.`,
  },
  {
    ask: "At which α from 0° to 180° does the knight at z₁ = 2, seen from z₂ = 6, appear turned the most?",
    before: UP, unit: "degrees", tolerance: 5, after: () => ({ alpha: QUESTIONS[7].answer() }),
    answer: () => mostTurned(2, 6),
    why: () => `There cos α = −z₁/z₂, and sin ν = z₁/z₂: ν = ${degreesText(nuDegrees(2, 6, mostTurned(2, 6)))}. Beyond, it turns back.`,
  },
  {
    ask: "At α = 180° the knight moves to z₁ = z₂ = 6. What fills the window?",
    before: { ...UP, alpha: 180 }, after: { z1: 6 }, choices: ["nothing: it is dark", "the whole knight, very small", "one point of the knight"],
    answer: () => (Number.isFinite(equations.M(1, Math.PI)) ? 1 : 2),
    why: () => "You see only wood: one spot of the knight, straight before the eye, fills the window. All light to the eye passes through it, because the knight's image lies in the eye: the pole, where P is infinite.",
  },
  {
    ask: "Two windows of 120° each stand 2 tiles apart. How far in front of the first window is the image of a knight 2 tiles behind the second one?",
    before: { ...UP, ...BEYOND.series }, unit: "tiles", tolerance: 0.1, after: { E: [0.8, 0] },
    answer: () => 8 - equations.depth(2, 8, radians(120), [[2, radians(120)]])[0],
    why: () => "In Z, d is turned by −120° and z₁ by −240°: together they are −2 tiles, which is real. Your eye moves, and the image stays in the air.",
  },
];

export const revealed = new Map();  // the numbers of the questions, and the predictions that were made

export const isAsked = () => state.question >= 0 && !revealed.has(state.question);
