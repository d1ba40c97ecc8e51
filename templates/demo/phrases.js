// Parts of sentences.

import { radians } from "../live/geometry.js";
import { linear } from "./aim.js";
import { abs, arg, minus } from "./complex.js";
import { imagingPole, possibleError } from "./moment.js";
import { angle, brief, fixed, placeText, rough } from "./numbers.js";
import { state } from "./state.js";
import { contents, SHOWN } from "./contents.js";

export const pieceName = (piece) => piece.split("/").pop().replace(/\.\w+$/, "");
export const thing = () => (state.scene === "spheres" ? "sphere" : pieceName(state.piece));

export function turnedBy(nu) {
  const text = angle(Math.abs(nu));
  return text === "0.0°" ? "not turned" : `turned by ${text}${text === "180.0°" ? "" : nu > 0 ? " counter-clockwise" : " clockwise"}`;
}

export const doubt = (now) => "Here the prediction can be wrong by "
  + `${possibleError(now) < 1280 ? `up to ${rough(possibleError(now))} pixels of 1280x960` : "more than the picture’s width"}: `
  + "the prisms are large, those of two sheets are nearly parallel, or the pole is near.";

export function listed(words) {
  return words.length > 1 ? `${words.slice(0, -1).join(", ")} and ${words.at(-1)}` : words[0];
}

const windowShows = (now) => listed(Object.keys(SHOWN).filter((name) => contents(now).has(name)).map((name) => SHOWN[name]));

// Where nothing of the object is in the window.
export function absent(now) {
  if (contents(now).size === 1 && contents(now).has("dark")) return "No light passes: the window is black.";
  const which = state.scene === "spheres" ? `sphere at z₁ = ${brief(now.z1)}` : thing();
  return `Nothing of the ${which} is in the window, which shows ${windowShows(now)}.`;
}

export function poleSentence(now) {
  const { M, seen } = now;
  const exact = !Number.isFinite(M), name = thing();
  const pole = exact ? "The pole" : "Near the pole";
  const { from, columns } = (exact && now.kind && linear(now.window, now.E, now.z1, now.z2)) || { from: now.E, columns: [] };
  const where = abs(minus(from, now.E)) < 1e-6 ? "straight before the eye" : `at (${placeText(from)})`;
  const part = exact ? `one point, ${where}` : `a part that is only ${rough(seen)} tiles wide`;
  if (imagingPole(now, now.z1, now.z2) === "line") {
    const along = columns.reduce((best, column) => (abs(column) > abs(best) ? column : best));
    const degrees = ((arg(along) / radians(1)) % 180 + 180) % 180;
    return `The pole: all light to the eye passes the ${name}’s plane in a line at ${fixed(degrees, 1)}°, through the point ${where}.`
      + (contents(now).has("thing") ? " Each of its points is drawn out across the window." : ` ${absent(now)}`);
  }
  if (!contents(now).has("thing") && !contents(now).has("pedestal")) {
    return `${pole}: all light to the eye passes the ${name}’s plane in ${part}. The ${name} is not there: the window shows ${windowShows(now)}.`;
  }
  if (!contents(now).has("thing")) return `${pole}: of the pedestal, ${part}, fills the window. Nothing of the ${name} is seen.`;
  return exact
    ? `The pole: one point of the ${name} fills the whole window, the point ${where}.`
    : `Near the pole: a part of the ${name}’s plane that is only ${rough(seen)} tiles wide fills the window.`;
}

// "2 tiles in front of the first window". An image behind the eye cannot be seen standing in the air.
export function imagePlace(W, z2, name) {
  const distance = `${brief(Math.abs(W))} ${Math.abs(W) === 1 ? "tile" : "tiles"}`;
  return `${distance} ${W < 0 ? "in front of" : "behind"} ${name}${-W > z2 ? ", behind your eye" : ""}`;
}
