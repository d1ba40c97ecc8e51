// Inputs, tabs, marked quantities, and keys.

import { SWITCHES } from "./address.js";
import { openQuestion } from "./asking.js";
import { chooseBeyond, chosenBeyond, labels, replace, replacedNames } from "./beyond.js";
import { abs, arg, finite, minus } from "./complex.js";
import { $, clamped, data, pick } from "./data.js";
import * as equations from "./equations.js";
import { refresh } from "./frame.js";
import { moment } from "./moment.js";
import { angle, brief, placeText, point, prismsText, quantity, readNumber, SETTINGS, size } from "./numbers.js";
import { drawOverlay } from "./overlay.js";
import { pieceName } from "./phrases.js";
import { player } from "./player.js";
import { isAsked } from "./questions.js";
import { change, session, state, WHOLE } from "./state.js";
import { explanation } from "./text.js";

// The sliders: their ends, and the functions from a slider's place to its value and back.
const linear = (least, most, step) => ({ ends: [least, most], step, from: (place) => Number(place.toPrecision(4)), to: (x) => x });
const STEPS = 1000;
const log = (least, most) => ({
  ends: [0, STEPS], step: "any",
  from: (place) => Number((least * (most / least) ** (place / STEPS)).toPrecision(3)),
  to: (x) => (STEPS * Math.log(x / least)) / Math.log(most / least),
});
// Of a number that has both signs but is not 0, the large values are in the middle: there a lens is weak.
function reciprocal(least, most) {
  const { from, to } = log(most, least);
  return { ends: [-STEPS, STEPS], step: "any", from: (place) => (place < 0 ? -1 : 1) * from(Math.abs(place)), to: (x) => Math.sign(x) * to(Math.abs(x)) };
}
const sliderOf = ({ unit, least, most, size }) => (unit.startsWith("°") ? linear(Math.max(least, -180), Math.min(most, 180), 0.5)
  : least > 0 ? log(least, most) : size > 0 ? reciprocal(size, most) : linear(least, most, "any"));

const OF_SHEETS = Object.keys(data.parameters);
const DIRECTIONS = OF_SHEETS.filter((name) => data.parameters[name].kind === "direction");
const FIELDS = Object.entries({ L: "xy", E: "xy", ...Object.fromEntries(DIRECTIONS.map((name) => [name, "xyz"])) });
const SLIDERS = {
  z1: log(0.3, 300), z2: log(0.5, 150), prisms: log(1, 400), alpha2: linear(-180, 180, 0.5), d: log(0.4, 20),
  ...Object.fromEntries(OF_SHEETS.filter((name) => !DIRECTIONS.includes(name)).map((name) => [name, sliderOf(data.parameters[name])])),
};
const valueOf = (name) => {
  const x = SLIDERS[name].from(Number($(`slider-${name}`).value));
  return WHOLE.includes(name) ? Math.round(x) : x;
};

// A number as an input shows it.
const typed = (x) => String(Number(Math.abs(x) < 1000 ? x.toPrecision(4) : x.toFixed(0)));

for (const [name, { ends: [min, max], step }] of Object.entries(SLIDERS)) {
  const slider = Object.assign($(`slider-${name}`), { min, max, step });
  slider.addEventListener("input", () => given({ [name]: valueOf(name) }));
  numberField($(`number-${name}`), 1, (x) => ({ [name]: x }));
}
for (const [name, letters] of FIELDS) {
  [...letters].forEach((axis, k) => numberField($(`number-${name}${axis}`), 0.05, (x) => ({ [name]: state[name].map((old, n) => (n === k ? x : old)) })));
}

// Of the spheres, an arrow key on the slider of z1 chooses the next one.
$("slider-z1").addEventListener("keydown", (event) => {
  const aside = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
  if (!aside || state.scene !== "spheres") return;
  event.preventDefault();
  const { objects, z1 } = moment();
  const ordered = [...objects].sort((a, b) => a - b);
  given({ z1: ordered[clamped(ordered.indexOf(z1) + aside, [0, ordered.length - 1])] });
});

// A field for a number. The arrows up and down change it by a step.
function numberField(input, step, values) {
  input.addEventListener("input", () => {
    session.typing = input;
    const x = readNumber(input.value);
    if (!Number.isFinite(x)) return;
    given(values(x));
    const noSphere = input.id === "number-z1" && state.scene === "spheres" && Math.abs(moment().z1 / x - 1) > 1e-3;
    if (noSphere) session.refusals = [`No sphere is at z₁ = ${brief(x)}: the nearest one is chosen.`];
  });
  input.addEventListener("change", () => {
    session.typing = null;
    if (input.value.trim() && !Number.isFinite(readNumber(input.value))) session.refusals = [`“${input.value}” is not a number.`];
    refresh();
  });
  input.addEventListener("keydown", (event) => {
    const sign = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    const x = readNumber(input.value) + sign * step;
    if (!Number.isFinite(x)) return;
    event.preventDefault();
    session.typing = null;
    given(values(x));
  });
}

function given(values) {
  player.pause();
  change(values);
  refresh();
}

for (const input of document.querySelectorAll(".choice input")) {
  input.addEventListener("change", () => {
    player.pause();
    replace({ [input.name]: input.value }, [input.name]);
    refresh();
  });
}
for (const name of data.pieces) $("piece").append(new Option(pieceName(name), name));
$("beyond").addEventListener("change", () => {
  player.reset();
  chooseBeyond($("beyond").value);
  refresh();
});
$("undo").addEventListener("click", () => {
  given(pick(session.replaced.before, "scene", ...Object.keys(SETTINGS)));
  session.replaced = null;
  $("scrub").focus();  // the button Undo is gone
});
$("piece").addEventListener("change", () => given({ piece: $("piece").value }));
for (const name of SWITCHES) {
  $(`show-${name}`).addEventListener("change", (event) => {
    state[name] = event.target.checked;
    refresh();
  });
}

// Show the state in all inputs, except in a field that someone is typing in.
export function showInputs(now) {
  for (const name of Object.keys(SLIDERS)) {
    const x = name === "z1" || name === "z2" || (name === "d" && now.d) ? now[name] : state[name];
    const slider = $(`slider-${name}`);
    if (document.activeElement !== slider || Math.abs(valueOf(name) - x) > 0.01 * Math.abs(x)) slider.value = SLIDERS[name].to(x);
    slider.setAttribute("aria-valuetext", name === "prisms" ? prismsText(x) : quantity(name, x));
    put(`number-${name}`, x);
  }
  for (const [name, letters] of FIELDS) [...letters].forEach((axis, k) => put(`number-${name}${axis}`, state[name][k]));
  for (const id of ["slider-alpha", "number-alpha"]) $(id).disabled = now.sheet === "none" || now.sheet === "single";
  $("row-prisms").hidden = now.beyond && now.sheet !== "detailed";
  for (const id of ["slider-alpha2", "number-alpha2"]) $(id).disabled = now.sheet === "none";
  const beyond = chosenBeyond();
  $("beyond").value = beyond;
  for (const [name, text] of Object.entries(labels(beyond))) {
    if (!SLIDERS[name]) continue;
    $(`label-${name}`).textContent = text;
    $(`slider-${name}`).setAttribute("aria-label", `${name}: ${text}`);
    $(`number-${name}`).setAttribute("aria-label", `${name}, as a number: ${text}`);
  }
  for (const part of document.querySelectorAll("[data-for]")) part.hidden = !part.dataset.for.split(" ").includes(beyond);
  for (const id of ["slider-prisms", "number-prisms"]) $(id).disabled = now.sheet !== "detailed" && now.sheet !== "single";
  for (const input of document.querySelectorAll(".choice input")) input.checked = state[input.name] === input.value;
  $("piece").value = state.piece;
  $("piece-choice").hidden = state.scene !== "chess";
  for (const name of SWITCHES) $(`show-${name}`).checked = state[name];
  $("show-circles").disabled = !now.two;
  $("show-image").disabled = !now.two && !now.beyond;
}

function put(id, x) {
  if ($(id) !== session.typing) $(id).value = typed(x);
}

// ---- Numbers ----

export function showNumbers(now) {
  const some = now.two || now.Z || now.sheet === "none";
  $("value-r").textContent = size(now.r);
  $("value-Z").textContent = now.Z ? point(now.Z) : "–";
  const where = finite(now.place) ? `(${placeText(now.place)})` : now.nearPole ? "∞" : "–";
  const same = abs(minus(now.L, now.E)) < 1e-9;  // then no point is L = 0 and E = 1
  $("value-P").textContent = now.beyond ? where : some && !same ? point(now.P) : "–";
  $("about-P").textContent = now.Z ? "crosses the first window" : "crosses the sheets";
  $("value-nu").textContent = some ? angle(now.nu) : "–";
  $("value-M").textContent = now.sheet === "single" ? `${brief(now.M)} wide, ${Number.isFinite(now.height) ? brief(now.height) : "no limit"} high` : size(now.M);
  const real = now.sheet === "detailed" && `for ${prismsText(now.scene.prisms)}; the equation gives `;
  const fine = now.Z ? { nu: -arg(now.Z), M: now.z2 / abs(now.Z) } : { nu: equations.nu(now.r, now.alpha), M: equations.M(now.r, now.alpha) };
  $("about-nu").textContent = real ? real + angle(fine.nu) : "angle by which the object appears turned";
  $("about-M").textContent = real ? real + size(fine.M) : "times as large as if it stood in the " + (now.Z ? "first " : "") + "window";
  $("paper-diagram").textContent = now.Z ? "complex depth" : "as in the paper";
  $("of-prisms").hidden = now.sheet !== "detailed";
  $("sentence").textContent = explanation(now);
  $("undo").hidden = isAsked() || !replacedNames().length;
}

// ---- Marked quantities: in the picture, the diagram and the sketch ----

export function mark(name) {
  session.marked = name || session.pinned;
  drawOverlay(moment());
  showMarks();
}

export function showMarks() {
  for (const part of document.querySelectorAll("svg .q")) part.classList.toggle("marked", part.classList.contains(`q-${session.marked}`));
  document.body.classList.toggle("marking", Boolean(session.marked));
  for (const button of document.querySelectorAll("button.symbol")) button.setAttribute("aria-pressed", button.value === session.pinned);
}

for (const row of document.querySelectorAll("[data-quantity]")) {
  const { quantity: name } = row.dataset;
  row.addEventListener("pointerenter", () => !session.held && mark(name));
  row.addEventListener("pointerleave", () => mark(""));
  row.addEventListener("focusin", () => mark(name));
  row.addEventListener("focusout", () => mark(""));
}
for (const button of document.querySelectorAll("button.symbol")) {
  button.addEventListener("click", () => {
    session.pinned = session.pinned === button.value ? "" : button.value;
    mark(button.value === session.pinned ? session.pinned : "");
  });
}

// ---- Tabs ----

const TABS = [$("tab-explore"), $("tab-questions")];

export function drawTabs() {
  const open = state.question >= 0 ? 1 : 0;
  TABS.forEach((tab, n) => {
    tab.setAttribute("aria-selected", n === open);
    tab.tabIndex = n === open ? 0 : -1;
    $(tab.getAttribute("aria-controls")).hidden = n !== open;
  });
}

TABS.forEach((tab, n) => {
  tab.addEventListener("click", () => openQuestion(n ? session.lastQuestion : -1));
  tab.addEventListener("keydown", (event) => {
    if (event.key !== "ArrowLeft" && event.key !== "ArrowRight") return;
    event.preventDefault();
    TABS[1 - n].focus();
    TABS[1 - n].click();
  });
});

// ---- Keys ----

const KEYS = {
  " ": () => $("play").click(),
  p: () => given({ sheet: state.sheet === "ideal" ? "detailed" : "ideal" }),
  o: () => $("show-position").click(),
  c: () => $("show-circles").click(),
  i: () => $("show-image").click(),
  f: () => $("full-screen").click(),
  q: () => openQuestion(state.question < 0 ? session.lastQuestion : -1),
};
for (const n of data.presets.keys()) KEYS[n + 1] = () => player.choose(data.presets[n]);

// Whether the focused control needs a key itself.
function needs(target, key) {
  if (target.matches("select, textarea, input:not([type=checkbox], [type=radio], [type=range])")) return true;
  return key === " " && target.matches("button, input, summary, [role=tab]");
}

document.addEventListener("keydown", (event) => {
  const { target, key } = event;
  if (!$("shortcuts").checked || event.ctrlKey || event.altKey || event.metaKey || needs(target, key)) return;
  const action = KEYS[key.toLowerCase()];
  if (!action) return;
  event.preventDefault();
  action();
});
