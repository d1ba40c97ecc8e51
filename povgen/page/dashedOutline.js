// A dashed outline of the piece on the picture: a prediction by drawing, or what the picture has to be made to match.

import { radians } from "../liveview/geometry.js";
import { abs, arg, minus, plus, scaled, times, turn } from "./complex.js";
import { $ } from "./data.js";
import * as equations from "./equations.js";
import { say } from "./language.js";
import { apparentPosition, moment } from "./moment.js";
import { angle, brief } from "./numbers.js";
import { state } from "./state.js";

// The outline of a question: the angle `nu` in radians, and the magnification M; null if there is none.
export function dashedOutline(question, drawing) {
  if (question.match) return matching(question);
  if (!drawing) return null;
  const [degrees, size] = [Number($("draw-turn").value), 2 ** Number($("draw-size").value)];
  const found = { nu: radians(degrees), M: size * free(), free: free() };
  for (const [id, text] of Object.entries({ turn: angle(found.nu), size: brief(size) })) {
    $(`drawn-${id}`).textContent = text;
    $(`draw-${id}`).setAttribute("aria-valuetext", text);
  }
  return found;
}

// M without sheets.
const free = () => equations.M(state.z2 / state.z1, 0);

// What the picture of a question is to be like.
export function matching({ match: { alpha, z1 }, before: { z2 } }) {
  return { nu: equations.nu(z2 / z1, radians(alpha)), M: equations.M(z2 / z1, radians(alpha)) };
}

export const numbersOf = ({ nu, M }) => ({ nu: angle(nu), M: brief(M) });

// What is seen of the piece now: how its picture is turned, and how large it is.
function seen() {
  const now = moment(), h = 1e-3;
  const [right, up] = [[h, 0], [0, h]].map((step) => scaled(1 / h, minus(apparentPosition(now, plus(now.L, step)), apparentPosition(now))));
  return { nu: arg(plus(right, times([0, -1], up))), M: abs(right) };
}

const NEAR = { degrees: 2, share: 0.04 };  // a picture that lies on the outline, as an eye judges it

export function isMatched(question) {
  const wanted = matching(question), { nu, M } = seen();
  return Math.abs(arg(turn(nu - wanted.nu))) < radians(NEAR.degrees) && Math.abs(M / wanted.M - 1) < NEAR.share;
}

// A drawing beside what is seen, in words.
export function compared(drawn) {
  const { nu, M } = seen();
  return say("asking.drawn", { nu: angle(drawn.nu), M: brief(drawn.M / drawn.free), seen_nu: angle(nu), seen_M: brief(M / drawn.free) });
}

// Where the outline shows a point at d from L: the picture is turned about E.
export const dashedPoint = ({ nu, M }, d) => plus(state.E, scaled(M, times(turn(nu), minus(plus(state.L, d), state.E))));
