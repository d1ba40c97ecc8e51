// What the page says of the choices beyond the paper, in sentences.

import * as geometry from "../liveview/geometry.js";
import { bending } from "../liveview/sheets.js";
import { fieldOf, imageDepth } from "./apparent.js";
import { abs, arg, minus, quotient } from "./complex.js";
import { data } from "./data.js";
import { entry, say } from "./language.js";
import { angle, brief, briefly } from "./numbers.js";
import { imagePlace, ofKind, thing } from "./phrases.js";
import { RANGES, state } from "./state.js";

const REAL = 0.02;  // tiles: an imaginary part of Z below this blurs an image by less than the height of one of 100 prisms

// What sheets beyond the paper do, and where the image is.
export function work(now) {
  const [window, second] = now.windows, { values } = window, does = sentence(window);
  if (second) return [say("seen.first_and_second", { first: does, second: sentence(second) }), ...image(now)].join(" ");
  if (now.lenses) {
    const field = angle(Math.atan(fieldOf(values)));
    return `${values.ratio === 1 ? does : sentence(window, "sentence_ratio")} ${ofKind("lenticular", "remark", { field })}`;
  }
  const turned = rotationBy(bending(window));
  if (turned !== null) return Math.abs(turned) < 1e-9 ? say("seen.does_nothing") : `${does} ${say("seen.papers_window")}`;
  return [does, ...(entry(`kinds.${now.sheet}.remark`) ? [ofKind(now.sheet, "remark")] : []), ...image(now)].join(" ");
}

// What the sheet in a window does.
const sentence = ({ sheet, values }, part = "sentence") => ofKind(sheet, part, {
  ...Object.fromEntries(Object.keys(data.parameters).map((name) => [name, briefly(name, values[name])])),
  "alpha/2": briefly("alpha", values.alpha / 2),
});

// Where the image is, if there is one.
function image(now) {
  const W = imageDepth(now.windows, now.z1);
  const place = Number.isFinite(W) ? imagePlace(W, now.z2, now.d ? "first_window" : "window") : say("image.infinite");
  return Number.isNaN(W) ? [] : [say("image.is", { thing: thing(), place })];
}

// The angle by which a sheet turns all light about its normal; null if it does something else.
function rotationBy(bend) {
  const rays = [[[0.3, 0.1], [0, 0]], [[-0.5, 0.4], [0.7, -0.2]], [[0.2, -0.6], [-0.4, 0.9]]];
  const [first, ...others] = rays.map(([slope, place]) => quotient(bend(slope, place) ?? [NaN, NaN], slope));
  const same = Math.abs(abs(first) - 1) < 1e-9 && others.every((other) => abs(minus(other, first)) < 1e-9);
  return same ? arg(first) : null;
}

// Whether two windows that rotate light form an image, and where. Z - z2 is the image's distance behind the first window, if it is real: docs/beyond.md.
export function imageSentence({ scene, Z, z1, z2, total }) {
  if (Math.abs(Z[1]) <= REAL) {
    const W = Z[0] - z2;
    if (Math.abs(W) < REAL) return say("image.real_in_window");
    return say("image.real", { place: imagePlace(W, z2, "first_window") });
  }
  const imaged = z1 + Z[1] / Math.sin(total);  // where Z is real
  const least = geometry.depth(scene) / 2 + (scene.name === "chess" ? data.pedestals[state.piece] : 0);
  const instead = imaged > least && imaged < RANGES.z1[1] ? ` ${say("image.instead", { z1: brief(imaged) })}` : "";
  return say("image.none", { thing: thing() }) + instead;
}
