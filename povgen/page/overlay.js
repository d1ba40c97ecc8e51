// What is drawn on the picture: predicted positions, circles, the predicted image, the caption, and a key.

import { radians } from "../liveview/geometry.js";
import { hasPiece } from "../liveview/presets.js";
import { abs, arg, finite, minus, plus, scaled, times, turn } from "./complex.js";
import { $ } from "./data.js";
import * as equations from "./equations.js";
import { angle, brief, say } from "./language.js";
import { apparentOutline, apparentPosition, appearance, markedPosition, moment, NEAR_POLE, sceneValues, unsure } from "./moment.js";
import { outlineOf } from "./outline.js";
import { bare } from "./phrases.js";
import { povray } from "./player.js";
import { found } from "./questions.js";
import { along, awayP, branches, corner, corners, curve, dot, edge, line, step, svg, triangle, words } from "./shapes.js";
import { session, state } from "./state.js";
import { caption } from "./text.js";

export const overlay = $("overlay");
export const stage = $("stage");

let drawnView = sceneValues().view;  // height of the picture that is drawn, tiles
// From tiles of the plane z = 0 to pixels of the stage, from its centre.
export const tilePixels = () => stage.clientHeight / drawnView;
export const onStage = ([x, y]) => scaled(tilePixels(), [x, -y]);

export function drawOverlay(now) {
  const box = { width: stage.clientWidth, height: stage.clientHeight };
  drawnView = now.scene.view;
  if (!box.width) return;
  const least = Math.max(12, document.body.classList.contains("present") ? innerHeight / 40 : 0);
  const rem = Math.max(least, box.height / 36);
  const parts = [];
  if (now.two && (state.circles || PATHS.includes(session.marked))) parts.push(...paths(now));
  parts.push(...dashed(), ...image(now), ...construction(now, rem, box), ...marks(now, rem, box));
  parts.push(...key(now, rem));
  overlay.setAttribute("viewBox", `${-box.width / 2} ${-box.height / 2} ${box.width} ${box.height}`);
  overlay.style.fontSize = `${rem}px`;
  overlay.replaceChildren(...parts);
  if (state.caption) drawCaption(caption(now), box, rem);
  placeKey(box, rem, least / rem);
  $("hint").classList.toggle("covered", state.caption || povray.shown || state.compare !== "off");
  stage.classList.toggle("has-marks", state.position);
}

// The caption, in as many lines as it needs. They end above the lower edge.
function drawCaption(parts, { width, height }, rem) {
  const text = overlay.appendChild(words("say caption", [0, 0], ""));
  const lines = [];
  for (const part of parts) {
    const longer = [...lines.slice(-1), part].join("\u2003");
    text.textContent = longer;
    if (lines.length && text.getComputedTextLength() <= width - rem) lines[lines.length - 1] = longer;
    else lines.push(part);
  }
  const top = height / 2 - (1.3 * lines.length - 0.2) * rem;
  text.replaceChildren(...lines.map((line, n) => svg("tspan", { x: 0, y: top + 1.3 * n * rem }, line)));
}

const PATHS = ["alpha", "r", "z1", "z2"];  // the quantities that the paths show

// The paths of P: alpha constant, while z1 changes, and r constant, while alpha changes. A dark line is under each.
function paths(now) {
  const [prism] = now.prisms;
  const ofAlpha = (log) => onStage(apparentPosition(now, now.L, { ...now, z1: now.z2 * Math.exp(log) }));
  const infinite = equations.infiniteZ1(now.z2, now.alpha, prism).map((z1) => Math.log(z1 / now.z2));
  const ofR = (alpha) => onStage(apparentPosition(now, now.L, { ...now, alpha }));
  const lines = { "of-alpha q q-z1 q-z2": branches(ofAlpha, -8, 8, infinite), "of-r q q-r q-alpha": branches(ofR, -Math.PI, Math.PI, equations.infiniteAlpha(now.z1, now.z2, prism)) };
  if (!state.circles && state.level !== "expert") return [];
  return Object.entries(lines).flatMap(([kind, points]) => ["halo ", ""].map((under) => curve(`${under}${kind}${state.circles ? "" : " aid"}`, points)));
}

const hasImage = (now) => state.image && hasPiece(state.scene) && (now.two || now.beyond) && !now.beside;

// The piece's outline where the sheets show it, by the equations. It is also where the piece can be dragged.
function image(now) {
  if (!hasPiece(state.scene) || !finite(now.place) || now.M > 3 * NEAR_POLE) return [];
  const lines = outlineOf(state.piece).map((line) => apparentOutline(now, line.map((d) => plus(now.L, d))).map(onStage));
  return [svg("path", { class: `image q q-nu q-M${hasImage(now) ? "" : " hidden"}`, id: "image", d: along(lines, "Z") })];
}

// The outline that a question asks for, or that a user draws.
function dashed() {
  if (!session.dashed) return [];
  const d = along(outlineOf(state.piece).map((line) => line.map((d) => onStage(dashedPoint(session.dashed, d)))), "Z");
  return ["halo dashed", "dashed"].map((kind) => svg("path", { class: kind, d }));
}

// The triangle of figure 5, which is shown while one of its quantities is marked.
function construction(now, rem, box) {
  const [L, E] = [onStage(now.L), onStage(now.E)];
  const P = finite(now.place) ? onStage(now.place) : null;
  if (abs(minus(L, E)) < 1 || state.level === "simple") return [];
  const named = state.position ? [] : corners(L, E, P, rem, box);
  for (const part of named) part.classList.add("q-alpha", "q-r", "q-nu", "q-M");
  const parts = [...triangle(L, E, P, { alpha: now.two ? now.alpha : 0, nu: now.nu || 0 }, rem, box), ...named];
  for (const part of parts) part.classList.add("aid");
  return parts;
}

function marks(now, rem, box) {
  if (!state.position) return [];
  const [L, E, P] = [onStage(now.L), onStage(now.E), finite(now.place) ? onStage(now.place) : null];
  const parts = [...corner("L", L, [E, P], rem), ...eyeMark(E, rem)];
  const rings = [];
  now.objects.forEach((z1, k) => {
    const there = { ...now, z1, r: now.z2 / z1 };
    there.place = markedPosition(there);
    if (!finite(there.place)) return;
    const at = onStage(there.place);
    const chosen = z1 === now.z1;
    const out = edge(at, box, 0.6 * rem);
    const kind = `mark q q-P${chosen ? " chosen" : ""}${unsure(there) || now.beside ? " unsure" : ""}`;
    const reach = hasPiece(state.scene) ? 0.45 * rem : Math.max(3, tilePixels() * now.radii[k] * appearance(there).M || 0);
    if (!out) rings.push(dot(`halo ${kind}`, at, reach), dot(kind, at, reach, chosen ? "predicted" : ""));
    if (chosen) parts.push(...nameOfP(at, out, [L, E], rem, reach));
  });
  return [...rings, ...parts];
}

// E is an open ring, so that it hides nothing.
const eyeMark = (E, rem) => [dot("halo ring", E, 0.55 * rem), dot("ring q q-E", E, 0.55 * rem), words("point q q-E", step(E, Math.PI / 2, 1.4 * rem), "E")];

const nameOfP = (at, out, others, rem, reach) => (out ? awayP(out, rem, rem) : [corner("P", at, others, (reach + 0.9 * rem) / 1.1)[1]]);

// The entries of the key, each at the origin.
function key(now, rem) {
  const lines = [];
  if (state.position) lines.push(["mark chosen", "P"], ["dot", "L"], ["ring", "E"]);
  if (state.circles && now.two) lines.push(["of-alpha", "of_alpha"], ["of-r", "of_r"]);
  if (hasImage(now)) lines.push(["image", "image"]);
  if (!lines.length) return [];
  const entries = lines.map(([kind, name]) => {
    const entry = svg("g", { class: "entry" });
    const sign = kind.startsWith("of-") ? line(kind, [0, 0], [1.4 * rem, 0]) : dot(kind, [0.7 * rem, 0], (kind === "dot" ? 0.3 : 0.42) * rem);
    entry.append(sign, words("keyword", [1.8 * rem, 0], say(`overlay.${name}`)));
    return entry;
  });
  return [svg("rect", { class: "key", rx: 0.4 * rem }), ...entries];
}

// The key is a row above the window's frame. Where it would be too long, its letters shrink to `least` of their size, and then
// there are more rows.
function placeKey({ width, height }, rem, least) {
  const entries = [...overlay.querySelectorAll(".entry")];
  if (!entries.length) return;
  const wide = entries.map((entry) => entry.querySelector("text").getComputedTextLength() + 2.5 * rem);
  const room = width - rem, size = Math.max(least, Math.min(1, room / wide.reduce((all, one) => all + one)));
  let x = 0, row = 0, longest = 0;
  entries.forEach((entry, n) => {
    if (x && x + size * wide[n] > room) [x, row] = [0, row + 1];
    entry.setAttribute("transform", `translate(${x - width / 2 + rem} ${(0.8 + 1.35 * row) * size * rem - height / 2}) scale(${size})`);
    x += size * wide[n];
    longest = Math.max(longest, x);
  });
  const place = { x: 0.4 * rem - width / 2, y: 0.05 * rem - height / 2, width: longest + 0.5 * rem, height: (1.5 + 1.35 * row) * size * rem };
  for (const [name, value] of Object.entries(place)) overlay.querySelector(".key").setAttribute(name, String(value));
}

// ---- A dashed outline of the piece: a prediction by drawing, or what the picture has to be made to match ----

// The outline of a question: the angle `nu` in radians, and the magnification M; null if there is none.
export function dashedOutline(question, drawing) {
  if (question.match) return matching(question);
  if (!drawing) return null;
  const [degrees, size] = [Number($("draw-turn").value), 2 ** Number($("draw-size").value)];
  const drawn = { nu: radians(degrees), M: size * found(question.before, bare) };
  for (const [id, text] of Object.entries({ turn: angle(drawn.nu), size: brief(size) })) {
    $(`drawn-${id}`).textContent = text;
    $(`draw-${id}`).setAttribute("aria-valuetext", text);
  }
  return drawn;
}

// What the picture of a question is to be like.
export function matching({ match: { alpha, z1 }, before: { z2 } }) {
  return { nu: equations.nu(z2 / z1, radians(alpha)), M: equations.M(z2 / z1, radians(alpha)) };
}

export const numbersOf = ({ nu, M }) => ({ nu: angle(nu), M: brief(M) });

// What is seen of the piece now: how its picture is turned, and how large it is.
function seenPiece() {
  const now = moment(), h = 1e-3;
  const [right, up] = [[h, 0], [0, h]].map((step) => scaled(1 / h, minus(apparentPosition(now, plus(now.L, step)), apparentPosition(now))));
  return { nu: arg(plus(right, times([0, -1], up))), M: abs(right) };
}

const NEAR = { degrees: 2, share: 0.04 };  // a picture that lies on the outline, as an eye judges it

// Whether the picture lies on the outline: "true", or the number of the reason why it does not.
export function misfit(question) {
  const wanted = matching(question), { nu, M } = seenPiece();
  if (!(Math.abs(arg(turn(nu - wanted.nu))) < radians(NEAR.degrees))) return "0";
  return Math.abs(M / wanted.M - 1) < NEAR.share ? "true" : "1";
}

// A drawing beside what is seen, in words.
export function compared(drawn) {
  const { nu, M } = seenPiece();
  return say("asking.drawn", { nu: angle(drawn.nu), seen_nu: angle(nu), times: brief(M / drawn.M) });
}

// Where the outline shows a point at d from L: the picture is turned about E.
const dashedPoint = ({ nu, M }, d) => plus(state.E, scaled(M, times(turn(nu), minus(plus(state.L, d), state.E))));
