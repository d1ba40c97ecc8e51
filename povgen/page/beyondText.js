// What the page says of the choices beyond the paper, in sentences.

import * as geometry from "../liveview/geometry.js";
import { bending } from "../liveview/sheets.js";
import { fieldOf, imageDepth } from "./apparent.js";
import { kinds } from "./beyond.js";
import { abs, arg, minus, quotient } from "./complex.js";
import { contents } from "./contents.js";
import { data } from "./data.js";
import { entry, say } from "./language.js";
import { NEAR_POLE, unsure } from "./moment.js";
import { angle, brief, briefly, timesText } from "./numbers.js";
import { absent, bare, doubt, imagePlace, ofKind, poleSentence, thing, thingAt, turnedBy } from "./phrases.js";
import { RANGES, state } from "./state.js";

const REAL = 0.02;  // tiles: an imaginary part of Z below this blurs an image by less than the height of one of 100 prisms

export function seenThrough(now) {
  const { M, turned } = now;
  if (kinds().every((sheet) => sheet === "none") && contents(now).has("thing")) return say("seen.free_series", { thing: thing(), times: timesText(M) });
  if (now.Z) return seenInSeries(now);
  const does = now.d ? workOfTwo(now) : work(now);
  if (now.beside) return `${does} ${besideSentence()}`;
  if (now.nearPole) return `${does} ${poleSentence(now)}`;
  if (!contents(now).has("thing")) return `${does} ${absent(now)}`;
  if (!(M > 0) || !Number.isFinite(M)) return does;
  const values = { thing: thingAt(now.z1) };
  const seen = Number.isFinite(turned)
    ? say("seen.turned", { ...values, turned: turnedBy(turned, thing()), times: timesText(M / bare(now)) })
    : say("seen.area", { ...values, times: timesText((M / bare(now)) ** 2) });  // it can be distorted
  return `${does} ${seen}${doubtIfUnsure(now)}`;
}

const theWindow = ({ d }) => (d ? "first_window" : "window");
const doubtIfUnsure = (now) => (now.glass && unsure(now) && now.M <= NEAR_POLE ? ` ${doubt(now)}` : "");
const besideSentence = () => say("seen.beside", { thing: thing() });

// What a sheet beyond the paper does.
function work(now) {
  if (now.lenses) return workOfLenses(now.windows[0]);
  const turned = rotationBy(bending(now.windows[0]));
  if (turned !== null && Math.abs(turned) < 1e-9) return say("seen.does_nothing");
  const does = sentence(now.windows[0]);
  if (turned !== null) return `${does} ${say("seen.papers_window")}`;
  return [does, ...(entry(`kinds.${now.sheet}.remark`) ? [ofKind(now.sheet, "remark")] : []), ...image(now)].join(" ");
}

// What sheets of lenses do, and up to which angle.
function workOfLenses(window) {
  const field = angle(Math.atan(fieldOf(window.values)));
  return `${sentence(window, window.values.ratio === 1 ? "sentence" : "sentence_ratio")} ${ofKind("lenticular", "remark", { field })}`;
}

function workOfTwo(now) {
  const [first, second] = now.windows.map((window) => sentence(window));
  return [say("seen.first_and_second", { first, second }), ...image(now)].join(" ");
}

// What the sheet in a window does.
const sentence = ({ sheet, values }, part = "sentence") => ofKind(sheet, part, {
  ...Object.fromEntries(Object.keys(data.parameters).map((name) => [name, briefly(name, values[name])])),
  "alpha/2": briefly("alpha", values.alpha / 2),
});

// Where the image is, if there is one.
function image(now) {
  const W = imageDepth(now.windows, now.z1);
  const place = Number.isFinite(W) ? imagePlace(W, now.z2, theWindow(now)) : say("image.infinite");
  return Number.isNaN(W) ? [] : [say("image.is", { thing: thing(), place })];
}

// The angle by which a sheet turns all light about its normal; null if it does something else.
function rotationBy(bend) {
  const rays = [[[0.3, 0.1], [0, 0]], [[-0.5, 0.4], [0.7, -0.2]], [[0.2, -0.6], [-0.4, 0.9]]];
  const [first, ...others] = rays.map(([slope, place]) => quotient(bend(slope, place) ?? [NaN, NaN], slope));
  const same = Math.abs(abs(first) - 1) < 1e-9 && others.every((other) => abs(minus(other, first)) < 1e-9);
  return same ? arg(first) : null;
}

function seenInSeries(now) {
  const { M, nu, z1 } = now;
  if (now.beside) return besideSentence();
  if (now.nearPole) return poleSentence(now);
  if (!contents(now).has("thing")) return absent(now);
  if (Number.isNaN(nu)) return say("seen.torn", { thing: thing() }) + doubtIfUnsure(now);
  const values = { thing: thingAt(z1), turned: turnedBy(nu, thing()), times: timesText(M / bare(now)) };
  const seen = say(state.scene === "spheres" ? "seen.through_both_about_eye" : "seen.through_both", values);
  return `${seen} ${imageSentence(now)}${doubtIfUnsure(now)}`;
}

// Z - z2 is the image's distance behind the first window, if it is real: docs/beyond.md.
function imageSentence({ scene, Z, z1, z2, total }) {
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
