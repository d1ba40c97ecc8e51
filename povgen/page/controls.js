// Inputs, tabs, marked quantities, and keys.

import { hasPiece } from "../liveview/presets.js";
import { openQuestion } from "./asking.js";
import { abs, finite, minus } from "./complex.js";
import { $, clamped, data, element, on, refresh } from "./data.js";
import { angle, beginsNumber, brief, choose, entry, fill, fixed, LANGUAGES, localised, marked, placeText, point, prismsText, quantity, readNumber, say, size, spoken, SYMBOL, typedNumber, typedUnit, unitText, withUnit } from "./language.js";
import { appearance, moment } from "./moment.js";
import { drawOverlay } from "./overlay.js";
import { bare, pieceName } from "./phrases.js";
import { player } from "./player.js";
import { isAsked, QUESTIONS } from "./questions.js";
import { BEHIND_PRISMS, change, chooseBeyond, chooseSheet, chosenBeyond, isReplaced, kinds, labels, partsShown, RANGES, replace, session, state, SWITCHES, usesAlpha, WHOLE } from "./state.js";
import { explanation } from "./text.js";

// The sliders: their ends, and the functions from a slider's place to its value and back.
const linear = (least, most, step) => ({ ends: [least, most], step, from: (place) => Number(place.toPrecision(4)), to: (x) => x });
const STEPS = 1000;
const log = (least, most) => ({
  ends: [0, STEPS], step: 1,
  from: (place) => Number((least * (most / least) ** (place / STEPS)).toPrecision(3)),
  to: (x) => (STEPS * Math.log(x / least)) / Math.log(most / least),
});
// Of a number that has both signs but is not 0, the large values are in the middle: there a lens is weak.
function reciprocal(least, most) {
  const { from, to } = log(most, least);
  return { ends: [-STEPS, STEPS], step: 1, from: (place) => (place < 0 ? -1 : 1) * from(Math.abs(place)), to: (x) => Math.sign(x) * to(Math.abs(x)) };
}
function sliderOf(name) {
  const { unit, size } = data.parameters[name], [least, most] = RANGES[name];
  if (unit.startsWith("°")) return linear(least, most, 0.5);
  return least > 0 ? log(least, most) : size > 0 ? reciprocal(size, most) : linear(least, most, "any");
}

const OF_SHEETS = Object.keys(data.parameters);
const DIRECTIONS = OF_SHEETS.filter((name) => data.parameters[name].kind === "direction");
const FIELDS = Object.entries({ L: "xy", E: "xy", ...Object.fromEntries(DIRECTIONS.map((name) => [name, "xyz"])) });
const SLIDERS = {
  z1: log(0.3, 50), z2: log(0.5, 150), prisms: log(1, 400), alpha2: linear(...RANGES.alpha2, 0.5), d: log(0.4, 20),
  pupil: linear(...RANGES.pupil, 0.01), focus: log(1, 60),
  ...Object.fromEntries(OF_SHEETS.filter((name) => !DIRECTIONS.includes(name)).map((name) => [name, sliderOf(name)])),
};
const valueOf = (name) => {
  const x = SLIDERS[name].from(Number($(`slider-${name}`).value));
  return WHOLE.includes(name) ? Math.round(x) : x;
};

// A number as an input shows it.
const typed = (x) => (Number.isFinite(x) ? localised(String(Number(Math.abs(x) < 1000 ? x.toPrecision(4) : x.toFixed(0)))) : "∞");

for (const [name, { ends: [min, max], step }] of Object.entries(SLIDERS)) {
  const slider = Object.assign($(`slider-${name}`), { min, max, step: WHOLE.includes(name) ? "any" : step });  // a whole number is coarse
  slider.addEventListener("input", () => {
    given({ [name]: valueOf(name) });
    showSlider(name, moment());  // at once: a screen reader speaks it after the key
  });
  numberField($(`number-${name}`), name === "pupil" ? 0.01 : 1, (x) => ({ [name]: x }), name, () => SYMBOL[name]);
}
for (const [name, letters] of FIELDS) {
  [...letters].forEach((axis, k) => numberField($(`number-${name}${axis}`), 0.05, (x) => ({ [name]: state[name].map((old, n) => (n === k ? x : old)) }),
    name, () => say("settings.x_of", { axis, name: SYMBOL[name] ?? name })));
}

// A finger that moves up or down from a slider scrolls the page, and changes nothing. A browser moves the slider as soon as it is touched:
// this counts when the finger moves across, or is lifted.
let touched = null;
function settle() {
  touched.settled = true;
  touched.slider.value = touched.moved;  // a movie may have moved it since
  touched.slider.dispatchEvent(new Event("input", { bubbles: true }));
}
/** @type {Object<string, (event: any) => void>} */
const FINGER = {
  pointerdown: ({ target, pointerType, clientX }) => (touched = pointerType === "touch" && target.type === "range" ? { slider: target, before: target.value, x: clientX } : null),
  input(event) {
    if (event.target !== touched?.slider || touched.settled) return;
    touched.moved = event.target.value;
    event.stopImmediatePropagation();
  },
  pointermove: ({ clientX }) => touched?.moved && !touched.settled && Math.abs(clientX - touched.x) > 8 && settle(),
  pointerup() {
    if (touched?.moved && !touched.settled) settle();
    touched = null;
  },
  pointercancel() {
    if (touched && !touched.settled) touched.slider.value = touched.before;
    touched = null;
  },
};
for (const [event, action] of Object.entries(FINGER)) document.addEventListener(event, action, true);

// Of the spheres, an arrow key on the slider of z1 chooses the next one.
$("slider-z1").addEventListener("keydown", (event) => {
  const aside = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
  if (!aside || hasPiece(state.scene)) return;
  event.preventDefault();
  const { objects, z1 } = moment();
  const ordered = [...objects].sort((a, b) => a - b);
  given({ z1: ordered[clamped(ordered.indexOf(z1) + aside, [0, ordered.length - 1])] });
  showSlider("z1", moment());
});

// A field for a number of the quantity `name`. The arrows up and down change it by a step.
function numberField(input, step, values, name, symbol) {
  // Why the text is no number of this quantity, in sentences.
  const faults = () => {
    const { x, units } = typedNumber(input.value), unit = typedUnit(name), said = { text: input.value, name: symbol() };
    if (beginsNumber(input.value)) return [];
    if (!Number.isFinite(x)) return [say("controls.not_a_number", said)];
    if (!units.length || units.includes(unit)) return [];
    return [unit ? say("controls.unit", { ...said, unit: say(`units.${unit}`) }) : say("controls.no_unit", said)];
  };
  input.addEventListener("input", () => {
    session.typing = input;
    const x = readNumber(input.value), found = faults();
    if (Number.isFinite(x) && !found.length) given(values(x));
    else session.refusals = found;
    const noSphere = name === "z1" && !found.length && !hasPiece(state.scene) && Math.abs(moment().z1 / x - 1) > 1e-3;
    if (noSphere) session.refusals = [say("controls.no_sphere", { z1: brief(x) })];
    refuse(session.refusals.length > 0);
    refresh();
  });
  // The sentence below the picture says why a number is not allowed.
  const refuse = (refused) => {
    input.ariaInvalid = String(refused);
    if (refused) input.setAttribute("aria-describedby", "sentence");
    else input.removeAttribute("aria-describedby");
  };
  for (const end of ["change", "blur"]) {  // a text that is again what it was is no change
    input.addEventListener(end, () => {
      refuse(false);
      if (session.typing !== input) return;
      session.typing = null;
      refresh();
    });
  }
  input.addEventListener("keydown", (event) => {
    const sign = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    const x = readNumber(input.value) + sign * step;
    if (!Number.isFinite(x)) return;
    event.preventDefault();
    session.typing = null;
    refuse(false);
    given(values(x));
  });
}

function given(values) {
  $("hint").hidden = true;
  player.pause();
  change(values);
  session.replaced = null;
  refresh();
}

for (const input of document.querySelectorAll(".choice input")) {
  input.addEventListener("change", () => {
    $("hint").hidden = true;
    player.pause();
    replace({ [input.name]: input.value }, [input.name]);
    refresh();
  });
}
for (const name of data.pieces) $("piece").append(new Option("", name));
on("beyond", "change", () => {
  const { value } = $("beyond");
  player.reset();
  if (value in data.rooms.examples) Object.assign(session, { room: value, moved: {} });
  else chooseBeyond(value);
});
for (const name of ["sheet", "sheet2"]) {
  on(`of-${name}`, "change", ({ target }) => {
    player.pause();
    chooseSheet(name, target.value);
  });
}
$("level").addEventListener("change", () => given({ level: $("level").checked ? "expert" : "simple" }));
$("undo").addEventListener("click", () => {
  given(session.replaced.before);
  $("scrub").focus();  // the button Undo is gone
});
for (const name of ["piece", "light"]) $(name).addEventListener("change", () => given({ [name]: $(name).value }));
on("best-focus", "change", ({ target }) => given({ focus: target.checked ? "best" : moment().focus }));
for (const name of SWITCHES) on(`show-${name}`, "change", ({ target }) => (state[name] = target.checked));

const named = (name) => data.languages[name].name;
for (const name of [...LANGUAGES].sort((a, b) => named(a).localeCompare(named(b), "en"))) $("language").append(element("option", { value: name, lang: name }, named(name)));
on("language", "change", () => {
  choose($("language").value, true);
  session.refusals = [];
});

// Write all sentences that do not depend on the state: the language has changed.
export function fillPage() {
  fill();
  $("language").value = spoken.language;
  for (const part of document.querySelectorAll("[data-unit]")) part.textContent = unitText(part.dataset.unit);
  $("measure-help").replaceChildren(...entry("measure.help").map((text) => element("li", {}, text)));
  for (const option of $("piece").options) option.textContent = pieceName(option.value);
}

// The quantity that matters for the sheet: the movie's, if the sheet has an angle. A projector shows its slider, or that of
// what a lesson's step is about.
const mainSlider = () => session.about || (usesAlpha(state.sheet) ? player.preset.parameter : data.kinds[state.sheet]?.parameters.find((name) => SLIDERS[name]) ?? "z1");

function showSlider(name, now) {
  const x = ["z1", "z2", "focus"].includes(name) || (name === "d" && now.d) ? now[name] : state[name], slider = $(`slider-${name}`);
  if (document.activeElement !== slider || Math.abs(valueOf(name) - x) > 0.01 * Math.abs(x)) slider.value = SLIDERS[name].to(Math.min(x, 1e9));
  slider.setAttribute("aria-valuetext", name === "prisms" ? prismsText(x) : quantity(name, x));
  put(`number-${name}`, x);
}

// Show the state in all inputs, except in a field that someone is typing in.
export function showInputs(now) {
  for (const name of Object.keys(SLIDERS)) showSlider(name, now);
  for (const [name, letters] of FIELDS) [...letters].forEach((axis, k) => put(`number-${name}${axis}`, state[name][k]));
  const [first, second] = kinds().map((sheet) => sheet === "none" || sheet === "single");
  for (const [name, none] of Object.entries({ alpha: first, alpha2: second, prisms: !now.glass })) for (const part of ["slider", "number"]) $(`${part}-${name}`).disabled = none;
  for (const name of ["sheet", "sheet2"]) $(`of-${name}`).value = state[name];
  for (const option of $("of-sheet2").options) option.hidden = option.disabled = state.sheet === "detailed" && !BEHIND_PRISMS.includes(option.value);
  const beyond = chosenBeyond(), simple = state.level === "simple";
  const asking = state.question >= 0, measuring = session.measuring && !asking;
  const challenged = isAsked() && Boolean(QUESTIONS[state.question].goal);  // then what is seen stays in sight
  for (const [name, holds] of Object.entries({ simple, asking, challenged, measuring, compact: !simple || asking || measuring })) document.body.classList.toggle(name, holds);
  $("level").checked = !simple;
  $("best-focus").checked = state.focus === "best";
  const main = mainSlider();
  const hasSlider = !(state.large && state.light === "prism");  // a prism alone has no distances
  for (const name of Object.keys(SLIDERS)) $(`row-${name}`).classList.toggle("main", name === main && hasSlider);
  // Present shows one slider, and none beside a question, which can be about another alpha than that of its picture
  const { goal, match, after = {} } = isAsked() ? QUESTIONS[state.question] : {};
  const isOther = !goal && !match && (after.alpha ?? state.alpha) !== state.alpha;
  $("alpha-now").hidden = !document.body.classList.contains("present") || !usesAlpha(state.sheet) || isOther || (!asking && main === "alpha");
  $("alpha-now").textContent = `α = ${fixed(state.alpha, 1)}°`;
  $("play").classList.toggle("of-other", player.preset.parameter !== main);
  $("row-prisms").hidden = (now.beyond || simple) && !now.glass;
  $("beyond-choice").hidden = simple && beyond === "none";
  $("beyond").value = beyond;
  for (const [name, text] of Object.entries(labels(beyond))) {
    $(`label-${name}`).textContent = text;
    const part = DIRECTIONS.includes(name) ? "controls.component" : "controls.coordinate";
    for (const input of document.querySelectorAll(`.place[data-quantity="${name}"] input`)) input.ariaLabel = say(part, { name: SYMBOL[name] ?? name, label: text, axis: input.dataset.axis });
    if (!SLIDERS[name]) continue;
    const said = { name: SYMBOL[name], label: text };
    const [least, most] = RANGES[name];
    $(`slider-${name}`).ariaLabel = say("controls.slider", said);
    Object.assign($(`number-${name}`), { ariaLabel: say("controls.number", said), title: say("controls.range", { least: brief(least), most: withUnit(name, most) }) });
  }
  const shown = partsShown();
  for (const part of document.querySelectorAll("[data-for]")) part.hidden = !part.dataset.for.split(" ").some((name) => shown.includes(name));
  for (const input of document.querySelectorAll(".choice input")) input.checked = state[input.name] === input.value;
  for (const name of ["piece", "light"]) $(name).value = state[name];
  $("piece-choice").hidden = !hasPiece(state.scene);
  for (const name of SWITCHES) $(`show-${name}`).checked = state[name];
  $("of-stray").hidden = !now.glass && state.light !== "prism";  // an ideal sheet has none
  $("show-circles").disabled = !now.two;
  $("show-image").disabled = !now.two && !now.beyond;
}

const put = (id, x) => $(id) !== session.typing && ($(id).value = typed(x));

// What a word means is spoken when it is shown.
for (const part of document.querySelectorAll(".explained")) part.addEventListener("toggle", ({ newState }) => newState === "open" && part.focus());

// ---- Numbers ----

const wideAndHigh = ({ M, height }, unit = 1) => say("numbers.wide_and_high", { width: brief(M / unit), height: Number.isFinite(height) ? brief(height / unit) : say("numbers.no_limit") });

export function showNumbers(now) {
  const some = now.two || now.Z || now.sheet === "none";
  $("value-r").textContent = size(now.r);
  $("value-Z").textContent = now.Z ? point(now.Z) : "–";
  const where = finite(now.place) ? `(${placeText(now.place)})` : now.nearPole ? "∞" : "–";
  const same = abs(minus(now.L, now.E)) < 1e-9;  // then no point is L = 0 and E = 1
  $("value-P").textContent = now.beyond ? where : some && !same ? point(now.P) : "–";
  $("about-P").innerHTML = marked(say(now.d ? "numbers.P_series" : now.beyond ? "numbers.P_in_tiles" : "numbers.P"));
  $("value-nu").textContent = some ? angle(now.nu) : now.sheet === "single" ? say("numbers.mirrored") : "–";
  $("value-M").textContent = now.sheet === "single" ? wideAndHigh(now) : size(now.M);
  $("value-bare").textContent = now.sheet === "single" ? wideAndHigh(now, bare(now)) : some && Number.isFinite(now.M) ? size(now.M / bare(now)) : now.nearPole ? "∞" : "–";
  const real = some && now.glass;
  const byEquation = (value) => say("numbers.for_prisms", { prisms: prismsText(now.scene.prisms), value });
  const fine = real && appearance({ ...now, prisms: [] });
  $("about-nu").textContent = real ? byEquation(angle(fine.nu)) : state.level === "simple" || now.sheet === "single" ? "" : say("numbers.nu");  // the simple name says it
  $("about-bare").hidden = now.sheet === "single";
  $("about-M").textContent = real ? byEquation(size(fine.M)) : say(`numbers.${now.Z ? "M_series" : now.sheet === "single" ? "M_single" : "M"}`);
  $("paper-diagram").textContent = say(now.Z ? "page.complex_depth" : "page.as_paper");
  $("of-prisms").hidden = !real;
  $("sentence").textContent = explanation(now);
  $("undo").hidden = isAsked() || !isReplaced();
}

// ---- Marked quantities: in the picture, the diagram and the sketch ----

export function mark(name) {
  session.marked = name || session.pinned;
  drawOverlay(moment());
  showMarks();
}

export function showMarks() {
  const pinned = document.querySelector(`button.symbol[value="${session.pinned}"]`);
  if (pinned?.checkVisibility() === false && !document.body.classList.contains("present")) {  // nobody could release it
    session.pinned = "";
    return mark("");
  }
  for (const part of document.querySelectorAll("svg .q")) part.classList.toggle("marked", part.classList.contains(`q-${session.marked}`));
  document.body.classList.toggle("marking", Boolean(session.marked));
  for (const button of document.querySelectorAll("button.symbol")) button.setAttribute("aria-pressed", button.value === session.pinned);
}

for (const row of document.querySelectorAll("[data-quantity]")) {
  const { quantity: name } = row.dataset;
  for (const event of ["pointerenter", "focusin"]) row.addEventListener(event, () => session.held || mark(name));
  for (const event of ["pointerleave", "focusout"]) row.addEventListener(event, () => mark(""));
}
for (const button of document.querySelectorAll("button.symbol")) {
  button.addEventListener("click", () => {
    session.pinned = session.pinned === button.value ? "" : button.value;
    mark(button.value === session.pinned ? session.pinned : "");
  });
}

// ---- Tabs ----

$("skip").addEventListener("click", () => TABS.find(({ tabIndex }) => tabIndex === 0).focus());
const TABS = [$("tab-explore"), $("tab-questions"), $("tab-measure")];

export function drawTabs() {
  const open = state.question >= 0 ? 1 : session.measuring ? 2 : 0;
  TABS.forEach((tab, n) => {
    tab.setAttribute("aria-selected", n === open);
    tab.tabIndex = n === open ? 0 : -1;
    $(tab.getAttribute("aria-controls")).hidden = n !== open;
  });
}

TABS.forEach((tab, n) => {
  tab.addEventListener("click", () => {
    session.measuring = n === 2;
    openQuestion(n === 1 ? session.lastQuestion : -1);
    if (session.measuring) state.large = false;  // the picture is measured
    refresh();
  });
  tab.addEventListener("keydown", (event) => {
    const aside = { ArrowLeft: -1, ArrowRight: 1 }[event.key], other = TABS.at((n + aside) % TABS.length);
    if (!aside) return;
    event.preventDefault();
    other.focus();
    other.click();
  });
});

// ---- Keys ----

const KEYS = {
  p: () => given({ sheet: state.sheet === "ideal" ? "detailed" : "ideal" }),
  f: () => document.fullscreenEnabled && $("full-screen").click(),
  q: () => openQuestion(state.question < 0 ? session.lastQuestion : -1),
};
for (const [key, id] of Object.entries({ " ": "play", o: "show-position", c: "show-circles", i: "show-image", l: "show-large" })) KEYS[key] = () => $(id).click();
for (const n of data.presets.keys()) KEYS[n + 1] = () => player.choose(data.presets[n]);

// Whether the focused control needs a key itself.
const needs = (target, key) => target.matches("select, textarea, input:not([type=checkbox], [type=radio], [type=range])")
  || (key === " " && target.matches("button, input, summary, [role=tab]"));

// What a key does, if it is a shortcut here.
export function shortcut({ target, key, ctrlKey, altKey, metaKey }) {
  if ($("shortcuts").checked && !document.querySelector("dialog[open]") && !ctrlKey && !altKey && !metaKey && !needs(target, key)) return KEYS[key.toLowerCase()];
}
document.addEventListener("keydown", (event) => {
  const action = shortcut(event);
  if (!action) return;
  event.preventDefault();
  action();
});
