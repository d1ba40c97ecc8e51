// What the page says of the choices beyond the paper, in sentences.

import * as geometry from "../live/geometry.js";
import { data } from "./data.js";
import { unsure } from "./moment.js";
import { brief, fixed, timesText } from "./numbers.js";
import { absent, doubt, imagePlace, poleSentence, thing, turnedBy } from "./phrases.js";
import { RANGES, state } from "./state.js";
import { contents } from "./contents.js";

const REAL = 0.02;  // tiles: an imaginary part of Z below this blurs an image by less than the height of one of 100 prisms

export function seenThrough(now) {
  const { sheet, M, degrees } = now;
  if (sheet === "none" && contents(now).has("thing")) return `Nothing is in the windows: the ${thing()} is seen as it is, ${timesText(M)} times as large as if it stood in the first window.`;
  if (now.Z) return seenInSeries(now);
  const does = Math.abs(Math.sin(geometry.radians(degrees) / 2)) < 1e-9 && sheet === "axis" ? "At this angle the sheet does nothing." : WORK[sheet](now);
  if (now.nearPole) return `${does} ${poleSentence(now)}`;
  if (!contents(now).has("thing")) return `${does} ${absent(now)}`;
  if (!(M > 0) || !Number.isFinite(M)) return does;
  const which = state.scene === "spheres" ? ` at z₁ = ${brief(now.z1)}` : "";
  if (sheet === "lenslets") return `${does} The ${thing()}${which} appears ${timesText(M)} times as large as if it stood in the window.`;
  return `${does} The ${thing()}${which} has ${timesText(M * M)} times the area that it would have in the window.`;  // it can be distorted
}

// What each of the other sheets does.
const WORK = {
  axis({ scene: { axis }, degrees }) {
    const what = `The sheet rotates light by ${fixed(degrees, 1)}° about the axis (${axis.map(brief).join(", ")})`;
    return axis[0] || axis[1] ? `${what}. No prisms are known that do this.` : `${what}: that is the paper’s window.`;
  },
  refraction({ scene: { ratio }, degrees }) {
    if (degrees % 360 === 0) return `Snell’s law: the sheet multiplies the sine of the angle by ${brief(ratio)}.`;
    const what = `The sheet refracts light, with a complex ratio of indices: it multiplies the sine of the angle by ${brief(ratio)}, and turns light by`;
    return `${what} ${fixed(degrees, 1)}°. ${ratio === 1 ? "That is the paper’s window." : "No prisms are known that do this."}`;
  },
  lenslets({ scene: { ratio }, degrees, z1, z2 }) {
    const turned = Math.abs(degrees) % 360 === 180;
    if (!turned) return `The sheet multiplies the light’s slope by ${brief(ratio)}, and turns it by ${fixed(degrees, 1)}°. Real lenslets turn it by 180°.`;
    return `Pairs of lenslets multiply the light’s slope by −f₁/f₂ = −${brief(ratio)}. They form an image ${imagePlace(-z1 / ratio, z2, "the window")}.`;
  },
  mirror: ({ degrees }) => `The sheet mirrors the light’s slope about a line at ${fixed(degrees / 2, 1)}°, as one sheet of prisms does.`,
};

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
