// Parts of sentences.

import { radians, shape } from "../liveview/geometry.js";
import { hasPiece } from "../liveview/presets.js";
import { linear } from "./apparent.js";
import { abs, arg, minus } from "./complex.js";
import { data } from "./data.js";
import { angle, brief, entry, fixed, forms, listed, percent, placeText, rough, say, tilesText } from "./language.js";
import { contents, imagingPole, possibleError, SHOWN } from "./moment.js";
import { at, lightInWindow } from "./rays.js";
import { state } from "./state.js";

export const pieceName = (piece) => pieceForms(piece).name;
const pieceForms = (piece) => (entry(`things.${piece}`) ? forms(piece) : forms("own", { piece: piece.split("/").pop().replace(/\.\w+$/, "") }));

// The magnification without sheets.
export const bare = ({ z1, z2, d = 0 }) => z2 / (z2 + d + z1);

// The forms of the name of the object at L. Of the spheres, that at a distance z1 is meant.
export const thing = () => (hasPiece(state.scene) ? pieceForms(state.piece) : forms("sphere"));
export const thingAt = (z1) => (hasPiece(state.scene) ? thing() : forms("sphere_at", { z1: brief(z1) }));

// Where a point is, for those who do not see it. `middle` is the name of the sentence for one before or behind the window's middle.
export function placeSaid([x, y], middle = "middle") {
  const ways = [[x, "right", "left"], [y, "up", "down"]].filter(([x]) => Math.abs(x) >= 0.005)
    .map(([x, more, less]) => say(`place.${x > 0 ? more : less}`, { tiles: tilesText(Math.abs(x)) }));
  return ways.length ? say("place.from", { list: listed(ways) }) : say(`place.${middle}`);
}

// Where rays go, for those who do not see them: through the window, and from there to the plane of the eye or of the object.
export function raysSaid({ windows, z1, z2 }, rays) {
  const good = rays.filter(({ kind }) => kind === "designed");
  if (!good.length) return "";
  const [z, point] = state.light === "pencil" ? [-z2, "E"] : [windows.at(-1).z + z1, "L"];
  /** @type {(points: any[]) => any} */
  const middle = (points) => [0, 1].map((k) => points.reduce((sum, each) => sum + each[k] / points.length, 0));
  const ends = good.map((ray) => at(ray, z)), place = middle(ends);
  const said = say("light.where", { window: placeSaid(middle(good.map(({ points }) => points[1]))), point, place: placeSaid(place) });
  if (good.length === 1) return said;
  return `${said} ${say("light.spread", { tiles: tilesText(middle(ends.map((end) => [abs(minus(end, place)), 0]))[0], (x) => fixed(x, 2)) })}`;
}

// `of`: the forms of the name of what appears turned. In some languages its gender counts.
export function turnedBy(nu, of) {
  const degrees = (Math.abs(nu) / radians(1)).toFixed(1);
  const way = { "0.0": "none", "180.0": "half" }[degrees] ?? (nu > 0 ? "counter_clockwise" : "clockwise");
  return say(`turned.${way}`, { angle: angle(Math.abs(nu)), thing: of });
}

// By how much the prediction can be wrong: `possibleError` is in pixels of a picture that is 1280 wide. Other sentences name a cause that
// is not the prisms' size: the pole, or dark bands.
export function doubt(now) {
  const error = possibleError(now), isOther = now.nearPole || now.windows.some(makesBands);
  const said = error < 1280 ? say("seen.doubt", { share: percent(Math.ceil(error / 12.8) / 100) }) : say("seen.doubt_wide");
  return isOther ? said : `${say("seen.large")} ${said}`;
}

// The shares of the light in the window.
function percents({ designed, stray }) {
  const whole = [designed, stray].map((share) => Math.round(100 * share));
  return Object.fromEntries(["designed", "stray", "lost"].map((name, k) => [name, percent([...whole, 100 - whole[0] - whole[1]][k] / 100)]));
}
export const lightShares = (now) => say("light.shares", percents(lightInWindow(now)));

// The angle below which the sheets of a window make dark bands: povgen/limits.py.
function moireAlpha(window) {
  const [product, least] = data.limits.moire, count = window.values.aperture / shape(window).pitch;
  return count < least - 1e-9 ? 0 : product / count;
}
const makesBands = (window) => ["detailed", "lenticular"].includes(window.sheet) && Math.abs(((window.values.alpha + 540) % 360) - 180) < moireAlpha(window);

// The warnings about the light in the window: povgen/scene/warnings.py, with the same limits.
export function lightWarnings(now) {
  const light = lightInWindow(now), { designed } = data.limits, found = [];
  if (light && light.designed < designed * (1 - light.beside)) found.push(say("seen.stray", { ...percents(light), least: percent(designed) }));
  for (const [sheet, sentence] of [["detailed", "bands"], ["lenticular", "bands_lenses"]]) {
    const parallel = now.windows.find((window) => window.sheet === sheet && makesBands(window));
    if (parallel) found.push(say(`seen.${sentence}`, { least: rough(moireAlpha(parallel)) }));
  }
  return found;
}

const windowShows = (now) => listed(SHOWN.filter((name) => contents(now).has(name)).map((name) => say(`shown.${name}`)));

// What a kind of sheet is called, and what its texts say: `part` is a part of the table `kinds`.
export const ofKind = (sheet, part, values) => say(`kinds.${sheet}.${part}`, values);

// Where nothing of the object is in the window.
export function absent(now) {
  if (contents(now).size === 1 && contents(now).has("dark")) return say("absent.dark");
  return say("absent.other", { thing: thingAt(now.z1), list: windowShows(now) });
}

export function poleSentence(now) {
  const { M, seen } = now;
  const exact = !Number.isFinite(M);
  const { from, columns } = (exact && now.general && linear(now.windows, now.E, now.z1, now.z2)) || { from: now.E, columns: [] };
  const where = abs(minus(from, now.E)) < 1e-6 ? say("pole.before_eye") : say("pole.at", { place: placeText(from) });
  const values = { thing: thing(), where, tiles: tilesText(seen, rough), list: windowShows(now) };
  const sentence = (name) => say(`pole.${exact ? "" : "near_"}${name}`, values);
  if (imagingPole(now, now.z1, now.z2) === "line") {
    const along = columns.reduce((best, column) => (abs(column) > abs(best) ? column : best));
    const degrees = ((arg(along) / radians(1)) % 180 + 180) % 180;
    const line = say("pole.line", { ...values, angle: `${fixed(degrees, 1)}°` });
    return `${line} ${contents(now).has("thing") ? say("pole.drawn_out") : absent(now)}`;
  }
  if (contents(now).has("thing")) return sentence("thing");
  return sentence(contents(now).has("pedestal") ? "pedestal" : "elsewhere");
}

const AT_EYE = 0.02;  // of z2: so near to the eye, an image is neither in front of it nor behind it

// "2 tiles in front of the first window". An image at the eye or behind it cannot be seen standing in the air.
export function imagePlace(W, z2, window) {
  const place = W >= 0 ? "behind" : Math.abs(W + z2) < AT_EYE * z2 ? "at_eye" : -W > z2 ? "behind_eye" : "front";
  return say(`image.${place}`, { tiles: tilesText(Math.abs(W)), window: forms(window) });
}
