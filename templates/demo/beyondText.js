// What the page says of the choices beyond the paper, in sentences. The sentence about one kind of sheet is `sentence` in
// povgen/sheets/.

import * as geometry from "../live/geometry.js";
import { imageDepth } from "./aim.js";
import { abs, arg, minus, quotient } from "./complex.js";
import { data } from "./data.js";
import { unsure } from "./moment.js";
import { brief, briefly, timesText } from "./numbers.js";
import { absent, doubt, imagePlace, poleSentence, thing, turnedBy } from "./phrases.js";
import { RANGES, state } from "./state.js";
import { contents } from "./contents.js";

const REAL = 0.02;  // tiles: an imaginary part of Z below this blurs an image by less than the height of one of 100 prisms

export function seenThrough(now) {
  const { sheet, M, turned } = now;
  if (sheet === "none" && contents(now).has("thing")) return `Nothing is in the windows: the ${thing()} is seen as it is, ${timesText(M)} times as large as if it stood in the first window.`;
  if (now.Z) return seenInSeries(now);
  const does = work(now);
  if (now.nearPole) return `${does} ${poleSentence(now)}`;
  if (!contents(now).has("thing")) return `${does} ${absent(now)}`;
  if (!(M > 0) || !Number.isFinite(M)) return does;
  const which = state.scene === "spheres" ? ` at z₁ = ${brief(now.z1)}` : "";
  const seen = Number.isFinite(turned)
    ? `appears ${turnedBy(turned)}, and ${timesText(M)} times as large as if it stood in the window.`
    : `has ${timesText(M * M)} times the area that it would have in the window.`;  // it can be distorted
  return `${does} The ${thing()}${which} ${seen}`;
}

// What a sheet beyond the paper does.
function work(now) {
  const { sentence, remark } = now.kind;
  const turned = rotationBy(now.bend);
  if (turned !== null && Math.abs(turned) < 1e-9) return "With these values the sheet does nothing.";
  const does = sentence.replace(/\{(\w+)(?:\/(\d+))?\}/g, (_, name, part) => briefly(name, part ? now.scene[name] / part : now.scene[name]));
  if (turned !== null) return `${does} That is the paper’s window.`;
  const W = imageDepth(now.window, now.z1);
  const place = Number.isFinite(W) ? imagePlace(W, now.z2, "the window") : "infinitely far away";
  return [does, ...(remark ? [remark] : []), ...(Number.isNaN(W) ? [] : [`The ${thing()}’s image is ${place}.`])].join(" ");
}

// The angle by which a sheet turns all light about its normal; null if it does something else.
function rotationBy(bend) {
  const rays = [[[0.3, 0.1], [0, 0]], [[-0.5, 0.4], [0.7, -0.2]], [[0.2, -0.6], [-0.4, 0.9]]];
  const [first, ...others] = rays.map(([slope, place]) => quotient(bend(slope, place) ?? [NaN, NaN], slope));
  const same = Math.abs(abs(first) - 1) < 1e-9 && others.every((other) => abs(minus(other, first)) < 1e-9);
  return same ? arg(first) : null;
}

function seenInSeries(now) {
  const { sheet, M, nu, z1 } = now;
  if (now.beside) return `Light from L to the eye passes beside the second window: there the ${thing()} is not where the windows would show it.`;
  if (now.nearPole) return poleSentence(now);
  if (!contents(now).has("thing")) return absent(now);
  const which = state.scene === "spheres" ? `sphere at z₁ = ${brief(z1)} appears, about E,` : `${thing()} appears`;
  const large = `${timesText(M)} times as large as if it stood in the first window`;
  const unsafe = sheet === "detailed" && unsure(now) ? ` ${doubt(now)}` : "";
  return `Through both windows, the ${which} ${turnedBy(nu)}, and ${large}. ${imageSentence(now)}${unsafe}`;
}

// Z - z2 is the image's distance behind the first window, if it is real: docs/beyond.md.
function imageSentence({ scene, Z, z1, z2, total }) {
  if (Math.abs(Z[1]) <= REAL) {
    const W = Z[0] - z2;
    if (Math.abs(W) < REAL) return "Z is real: the image is in the first window.";
    return `Z is real: the image is ${imagePlace(W, z2, "the first window")}.`;
  }
  const imaged = z1 + Z[1] / Math.sin(total);  // where Z is real
  const least = geometry.depth(scene) / 2 + (scene.name === "chess" ? data.pedestals[state.piece] : 0);
  const instead = imaged > least && imaged < RANGES.z1[1] ? ` What stands at z₁ = ${brief(imaged)} has one.` : "";
  return `Z is not real: the ${thing()} has no image.${instead}`;
}
