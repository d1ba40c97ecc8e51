// What the page says of what is seen, in sentences.

import { radians } from "../liveview/geometry.js";
import * as presets from "../liveview/presets.js";
import { fieldOf, imageDepth } from "./apparent.js";
import { finite } from "./complex.js";
import { $, data } from "./data.js";
import { angle, brief, briefly, entry, fixed, forms, listed, prismsText, quantity, say, SYMBOL, tilesText, timesText } from "./language.js";
import { contents, frameDepth, outside, pupilBlur, unsure } from "./moment.js";
import { absent, bare, doubt, imagePlace, lightWarnings, ofKind, placeSaid, poleSentence, thing, thingAt, turnedBy } from "./phrases.js";
import { ask, found, isAsked, QUESTIONS } from "./questions.js";
import { isEmpty, kinds, RANGES, session, state, usesAlpha } from "./state.js";

// Whether a class is to find what is seen: a question is asked, or it is to be measured.
export const isToBeFound = () => isAsked() || (session.measuring && state.question < 0 && !session.answered);

// What is seen, in a sentence or two. A challenge is to find a setting: what is seen there is no secret.
export function explanation(now) {
  const question = QUESTIONS[state.question], asked = isAsked() ? [question.goal ? seen(now) : say("seen.asked")] : [];
  if (isToBeFound()) return [...asked, ...limitsMet(now)].join(" ");
  const first = question?.says?.(now);
  return [...(first ? [first] : []), seen(now), ...remarks(now)].join(" ");
}

// What a screen reader speaks after a change, of these sentences those that are new. That a value was not allowed is spoken first, and
// alone if it was typed: then nothing has changed.
export function heard(now) {
  const limits = limitsMet(now), light = state.light === "ray" || !$("light-says").checkVisibility() ? [] : [$("light-says").textContent];
  if (limits.length) return [...limits, ...(session.refusals.length || isToBeFound() ? [] : [seen(now)])];
  const points = pointsSaid(now), isMoved = points !== heardPoints;
  heardPoints = points;
  const question = isAsked() && document.body.classList.contains("present") ? [ask(QUESTIONS[state.question])] : [];  // elsewhere it has the focus
  const beside = state.compare === "off" || isToBeFound() ? [] : [`${ofKind(state.compare, "choice")}: ${found({ sheet: state.compare, windows: 1, z1: now.z1 + (now.d || 0) }, seen)}`];
  return [...question, ...(QUESTIONS[state.question]?.says?.(now) ? [] : mountains(now)), explanation(now), points, ...(isMoved ? appears(now) : []), ...light, ...beside];
}

const pointsSaid = ({ L, E }) => say("describe.points", { L: placeSaid(L), E: placeSaid(E) });
let heardPoints = "";  // where L and E are, as it has been spoken last

// Where in the window the object's point L is seen.
function appears(now) {
  const isSeen = !isToBeFound() && !isEmpty() && !now.beside && !now.nearPole && finite(now.place) && !outside(now.place, now.scene);
  return isSeen ? [say("describe.appears", { P: placeSaid(now.place, "in_middle") })] : [];
}

// Of all that is seen, the object; before it, what sheets beyond the paper do.
export const seen = (now) => [...(now.general ? [work(now)] : []), ...objectSeen(now)].join(" ");

function objectSeen(now) {
  const { M, nu, height, z1, z2, general, beyond, turned = nu } = now, shown = contents(now).has("thing");
  const times = (size) => timesText(size / bare(now)), single = now.sheet === "single" && !beyond;
  if (shown && isEmpty()) return [say(beyond ? "seen.free_series" : "seen.free", { thing: thing() })];
  if (single && !Number.isFinite(height)) return [say("seen.single_pole", { times: times(M) })];
  if (now.beside) return [say("seen.beside", { thing: thing() })];
  if (now.nearPole) return [poleSentence(now)];
  if (!shown) return [absent(now)];
  if (single) return [say(z1 > z2 ? "seen.single_upside_down" : "seen.single", { thing: thing(), width: times(M), height: times(height) })];
  if (general && !(M > 0 && Number.isFinite(M))) return [];
  if (general && !Number.isFinite(turned)) return [say("seen.area", { thing: thingAt(z1), times: timesText((M / bare(now)) ** 2) })];  // it can be distorted
  if (Number.isNaN(nu) && !general) return [say("seen.torn", { thing: thing() })];
  const sentence = `seen.${now.Z ? "through_both" : "turned"}${!presets.hasPiece(state.scene) && !general ? "_about_eye" : ""}`;
  return [say(sentence, { thing: thingAt(z1), turned: turnedBy(turned, thing()), times: times(M) }), ...(now.Z ? [imageSentence(now)] : [])];
}

// Which values were not allowed.
function limitsMet({ z1, z2, d, scene }) {
  const depth = frameDepth(scene);
  const deep = (name, value) => say(`limits.${name}${depth > 1 ? "_deep" : ""}`, { value: brief(value), depth: tilesText(depth) });
  const met = [...session.refusals];
  if (presets.hasPiece(state.scene) && state.z1 < z1 * 0.999) met.push(deep("piece", z1));
  if (d && state.d < d * 0.999) met.push(say("limits.windows", { value: brief(d) }));
  if (state.z2 < z2 * 0.999) met.push(deep("eye", z2));
  return met;
}

function remarks(now) {
  const { sheet, z1, z2, scene, degrees } = now;
  const found = [];
  if (now.two && Math.abs(Math.abs(degrees) - 180) < 0.05 && z1 < z2 * 0.95 && contents(now).has("thing")) {
    found.push(say("seen.floats", { tiles: tilesText(z1) }));
  }
  const limits = limitsMet(now);
  if (now.general && !finite(now.place) && !now.nearPole && contents(now).has("thing")) {
    limits.push(say(contents(now).size === 1 ? "seen.fills_without_path" : "seen.parts_without_path", { thing: thing() }));
  }
  if (limits.length) found.push(...limits);
  else if (!now.nearPole && !unsure(now) && finite(now.place) && outside(now.place, scene) && contents(now).has("thing")) {
    found.push(say(presets.hasPiece(state.scene) ? "seen.foot_outside" : "seen.middle_outside", { thing: thing() }));
  }
  if (scene.pupil && Number.isFinite(now.best) && contents(now).has("thing")) found.push(blurSaid(now));
  found.push(...lightWarnings(now));
  const isTorn = state.level === "simple" && Number.isNaN(now.nu) && !now.general;  // then there is no angle to be predicted
  if ((sheet !== "single" || now.beyond) && now.glass && unsure(now) && !now.beside && !isTorn) found.push(doubt(now));
  return found;
}

// By how much the pupil blurs the object, and whether another focus makes it sharp.
function blurSaid(now) {
  const { scene, best, focus, z1 } = now;
  const [blur, least] = [scene.inverse_focus, best].map((near) => `${fixed(pupilBlur(now, near) / radians(1 / 60), 1)}′`), none = `${fixed(0, 1)}′`;
  const sentence = least !== none ? "always" : blur !== none ? "now" : "not";
  return say(`seen.blurred_${sentence}`, { thing: thingAt(z1), blur, focus: tilesText(focus), best: tilesText(1 / best) });
}

// The description of the picture for those who do not see it.
export function describe(now) {
  const far = mountains(now);
  return [settingSaid(now), pointsSaid(now), ...appears(now), ...far, ...(far.length ? [say("describe.reason")] : []), explanation(now)].join(" ");
}

// What is seen through what, and the numbers of the setting: nothing of what it looks like.
export function settingSaid(now) {
  const prisms = prismsText(now.scene.prisms);
  const [first, second] = kinds().map((sheet) => ofKind(sheet, "model", { prisms }));
  const through = isEmpty() ? "free" : now.d ? "two" : "one";
  const seenAs = say(`describe.${through}`, { thing: thing(), first, second, tiles: now.d && tilesText(now.d) });
  const values = listed([...parametersOf(now).flat(), `z₁ = ${brief(now.z1)}`, `z₂ = ${quantity("z2", now.z2)}`, ...eyeValues(now)]);
  return `${seenAs} ${values}.`;
}

// By which angle the mountains turn: an object turns less.
function mountains(now) {
  if (isToBeFound() || !now.two || !now.alpha || now.nearPole || !presets.hasPiece(state.scene) || !contents(now).has("thing")) return [];
  return [say("describe.mountains", { turned: turnedBy(now.alpha, forms("mountains")) })];
}

// The values of the parameters of each window's sheet. Of the second window's, only α is its own.
function parametersOf({ windows }) {
  const names = windows.map(({ sheet }) => data.kinds[sheet]?.parameters ?? (usesAlpha(sheet) ? ["alpha"] : []));
  return windows.map(({ values }, n) => names[n].filter((name) => !n || name === "alpha" || !names[0].includes(name))
    .map((name) => `${SYMBOL[n && name === "alpha" ? "alpha2" : name]} = ${briefly(name, values[name])}`));
}

const eyeValues = ({ scene, focus }) => (scene.pupil ? [`p = ${brief(scene.pupil)}`, `s = ${brief(focus)}`] : []);

// The parts of the caption on the picture.
export function caption(now) {
  const differ = new Set(kinds()).size > 1;
  const names = kinds().map((sheet) => {
    const part = ["caption_beside", "caption", "choice"].filter((name) => differ || name !== "caption_beside").find((name) => entry(`kinds.${sheet}.${name}`));
    return ofKind(sheet, part, { number: now.scene.prisms });
  });
  const values = parametersOf(now);
  const second = now.d ? [...(names[1] === names[0] ? [] : [names[1]]), ...values[1], `d = ${brief(now.d)}`] : [];
  const parts = [names[0], ...values[0], ...second, `z₁ = ${brief(now.z1)}`, `z₂ = ${brief(now.z2)}`, ...eyeValues(now)];
  if ((!now.two && !now.Z) || isToBeFound()) return parts;
  const nu = Number.isNaN(now.nu) ? "?" : angle(now.nu);
  if (state.level === "simple") return [...parts, `ν = ${nu}`, `${say("page.size")} = ${brief(now.M / bare(now))}`];  // there r and M are not explained
  return [...parts, ...(now.Z ? [] : [`r = ${brief(now.r)}`]), `ν = ${nu}`, `M = ${brief(now.M)}`];
}

// ---- What sheets beyond the paper do ----

const REAL = 0.02;  // tiles: an imaginary part of Z below this blurs an image by less than the height of one of 100 prisms

// What sheets beyond the paper do, and where the image is.
function work(now) {
  const [window, second] = now.windows, { values } = window, does = sentence(window);
  if (second) return [say("seen.first_and_second", { first: does, second: sentence(second) }), ...image(now)].join(" ");
  if (now.lenses) {
    const field = angle(Math.atan(fieldOf(values)));
    return `${values.ratio === 1 ? does : sentence(window, "sentence_ratio")} ${ofKind("lenticular", "remark", { field })}`;
  }
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

// Whether two windows that rotate light form an image, and where. Z - z2 is the image's distance behind the first window, if it is real: docs/beyond.md.
function imageSentence({ scene, Z, z1, z2, total }) {
  if (Math.abs(Z[1]) <= REAL) {
    const W = Z[0] - z2;
    if (Math.abs(W) < REAL) return say("image.real_in_window");
    return say("image.real", { place: imagePlace(W, z2, "first_window") });
  }
  const imaged = z1 + Z[1] / Math.sin(total);  // where Z is real
  const least = presets.depth(scene) / 2 + (presets.hasPiece(scene.name) ? data.pedestals[state.piece] : 0);
  const instead = imaged > least && imaged < RANGES.z1[1] ? ` ${say("image.instead", { z1: brief(imaged) })}` : "";
  return say("image.none", { thing: thing() }) + instead;
}
