// What the page says of what is seen, in sentences.

import * as geometry from "../live/geometry.js";
import { replacedNames, usesAlpha } from "./beyond.js";
import { seenThrough } from "./beyondText.js";
import { finite } from "./complex.js";
import { NEAR_POLE, outside, unsure } from "./moment.js";
import { angle, brief, briefly, fixed, placeText, prismsText, SETTINGS, size, SYMBOL, timesText } from "./numbers.js";
import { absent, doubt, listed, poleSentence, thing, turnedBy } from "./phrases.js";
import { isAsked, QUESTIONS } from "./questions.js";
import { session, state } from "./state.js";
import { contents } from "./contents.js";

// What is seen, in a sentence or two. While a question is asked, the class is to find it.
export function explanation(now) {
  if (isAsked()) return ["What is seen is said with the answer.", ...limitsMet(now)].join(" ");
  const first = QUESTIONS[state.question]?.says?.(now);
  return [...(first ? [first] : []), seen(now), ...remarks(now)].join(" ");
}

function seen(now) {
  if (now.beyond) return seenThrough(now);
  const { sheet, M, nu, height, z1, z2 } = now;
  const large = `${timesText(M)} times as large as if it stood in the window`;
  if (sheet === "single" && !Number.isFinite(height)) {
    return `z₁ = z₂: one height fills the window from top to bottom, that of the eye. What is there is ${timesText(M)} times as wide as if it`
      + " stood in the window.";
  }
  if (now.nearPole) return poleSentence(now);
  if (!contents(now).has("thing")) return absent(now);
  if (sheet === "none") return `Nothing is in the window: the ${thing()} is seen as it is, ${large}.`;
  if (sheet === "single") {
    const across = `${timesText(M)} times as wide and ${timesText(height)} times as high as if it stood in the window`;
    return `One sheet mirrors up and down in the light's direction: the ${thing()} appears ${across}`
      + `${z1 > z2 ? ", and upside down" : ""}.`;
  }
  if (sheet === "detailed" && unsure(now)) return doubt(now);
  const which = state.scene === "spheres" ? `The sphere at z₁ = ${brief(z1)} appears, about E, ` : `The ${thing()} appears `;
  return `${which}${turnedBy(nu)}, and ${large}.`;
}

// Which values were not allowed.
function limitsMet({ z1, z2, d, scene }) {
  const depth = geometry.depth(scene);
  const frame = depth > 1 ? `the frame, which is ${brief(depth)} tiles deep` : "the frame";
  const met = [...session.refusals];
  if (state.scene === "chess" && state.z1 < z1 * 0.999) met.push(`z₁ is at least ${brief(z1)}: the piece would touch ${frame}.`);
  if (d && state.d < d * 0.999) met.push(`d is at least ${brief(d)}: the windows would touch.`);
  if (state.z2 < z2 * 0.999) met.push(`z₂ is at least ${brief(z2)}: the eye would be too near ${frame}.`);
  return met;
}

function remarks(now) {
  const { sheet, z1, z2, scene, degrees } = now;
  const found = [];
  if (now.two && Math.abs(Math.abs(degrees) - 180) < 0.05 && z1 < z2 * 0.95 && contents(now).has("thing")) {
    found.push(`It floats ${brief(z1)} tiles in front of the window: move the eye and watch.`);
  }
  const limits = limitsMet(now);
  if (now.kind && !finite(now.place) && !now.nearPole && contents(now).has("thing")) {
    const filled = contents(now).size === 1 ? `The ${thing()} fills the window` : `Parts of the ${thing()} are in the window`;
    limits.push(`${filled}, but no path of light from L to the eye was found.`);
  }
  if (limits.length) found.push(...limits);
  else if (!now.nearPole && !unsure(now) && finite(now.place) && outside(now.place, scene) && contents(now).has("thing")) {
    found.push(`P is outside the window, so ${thing() === "sphere" ? "this sphere’s middle" : `the ${thing()}’s foot`} is not seen.`);
  }
  const names = replacedNames();
  const one = names.length === 1 && !["sheet", "windows"].includes(names[0]);
  if (names.length) found.push(`Your ${listed(names.map((name) => SETTINGS[name]))} ${one ? "is" : "are"} replaced.`);
  if (sheet === "detailed" && unsure(now) && !(now.M <= NEAR_POLE) && !now.beside) found.push(doubt(now));
  return found;
}

// The description of the picture for those who do not see it.
export function describe(now) {
  const several = now.Z ? `, with a second window ${brief(now.d)} tiles behind the first one and α₂ = ${fixed(state.alpha2, 1)}°` : "";
  const model = {
    none: "without sheets", single: `through one sheet of ${prismsText(now.scene.prisms)}`, ideal: "through the ideal sheet",
    detailed: `through two sheets of ${prismsText(now.scene.prisms)}`,
  }[now.sheet] ?? `through an ideal sheet that ${now.kind.does}`;
  return `A ${thing()} seen ${model}${several}. ${parametersOf(now).map((text) => `${text}, `).join("")}z₁ = ${size(now.z1)} and z₂ = ${size(now.z2)} tiles.`
    + ` The object L is at ${placeText(now.L)}, the eye E at ${placeText(now.E)}. ${explanation(now)}`;
}

// The values of the sheet's parameters.
const parametersOf = ({ sheet, kind, scene }) =>
  Object.keys(kind?.parameters ?? (usesAlpha(sheet) ? { alpha: "" } : {})).map((name) => `${SYMBOL[name]} = ${briefly(name, scene[name])}`);

// The parts of the caption on the picture.
export function caption(now) {
  const { prisms } = now.scene;
  const sheet = now.kind?.choice ?? { none: "no sheet", single: `one sheet, N = ${prisms}`, detailed: `N = ${prisms}`, ideal: "ideal sheet" }[now.sheet];
  const second = now.Z ? [...(now.sheet === "none" ? [] : [`α₂ = ${fixed(state.alpha2, 1)}°`]), `d = ${brief(now.d)}`] : [];
  const parts = [sheet, ...parametersOf(now), ...second, `z₁ = ${brief(now.z1)}`, `z₂ = ${brief(now.z2)}`];
  if (!now.two && !now.Z) return parts;
  const nu = Number.isNaN(now.nu) ? "?" : angle(now.nu);
  return [...parts, ...(now.Z ? [] : [`r = ${brief(now.r)}`]), `ν = ${nu}`, `M = ${brief(now.M)}`];
}
