// A teacher's panel: what such windows are good for, the steps of a lesson, and a sheet of tasks to print.

import { still } from "../liveview/readout.js";
import { lasting, valuesOf } from "./address.js";
import { $, data, element, on, refresh, write } from "./data.js";
import { drawCode, page, printPicture } from "./handouts.js";
import { inTab, keep, work } from "./kept.js";
import { entry, marked, quantity, say, SETTINGS, SYMBOL, unbroken } from "./language.js";
import { moment, otherScene } from "./moment.js";
import { drawOther, overlayImage, view } from "./picture.js";
import { ask, choices, found, MOMENTS, QUESTIONS } from "./questions.js";
import { OPENING, partsShown, session, START, state, usesAlpha } from "./state.js";
import { isToBeFound, settingSaid } from "./text.js";

const asked = (name) => QUESTIONS.find((question) => question.name === name);

// What the steps of a lesson ask and show: settings of the page, with what says their names. A question comes before what answers it.
function stepsOf({ name, steps }) {
  let n = 0;
  return steps.map(({ shows, asks }) => [
    ...asks.map((question) => ({ setting: { question }, called: () => ask(asked(question)) })),
    ...shows.map((text) => {
      const setting = Object.fromEntries(new URLSearchParams(text)), k = n++;
      return { setting, called: () => entry(`lessons.${name}.names`)?.[k] ?? inNumbers(setting) };
    }),
  ]);
}
const SLIDES = data.lessons.flatMap((lesson) => stepsOf(lesson).flat());
const hashOf = (setting) => `#${new URLSearchParams({ ...setting, ...lasting() })}`;
/** @type {any[]} */
const steppers = [...$("lesson").querySelectorAll("button")];
let at = Number(inTab("lesson") || -1);  // the one that was opened last
/** @type {any} */
let linked = null;                       // a setting beside the lesson, which a link has opened since

// A setting is opened by its link, or by the buttons of Present. Its question is asked anew.
function opens(setting) {
  at = SLIDES.findIndex((each) => hashOf(each.setting) === hashOf(setting));
  linked = null;
  inTab("lesson", String(at));
  if (work.answers[setting.question]) work.answers[setting.question].shown = false;
  keep();
  refresh();
}

// Whether the page shows a setting: its question, or its numbers, wherever the eye and the object have been dragged.
/** @param {any} each */
function isShown({ question, ...setting }) {
  if (question) return QUESTIONS[state.question]?.name === question;
  const values = valuesOf(new URLSearchParams(setting)), wanted = { ...OPENING, ...START[values.scene ?? "chess"], ...values };
  return ["question", "scene", "light", ...SETTINGS].every((name) => ["L", "E"].includes(name) || String(state[name]) === String(wanted[name]));
}

// Where a button leads. What has been changed comes back first.
const stepTo = ({ value }) => SLIDES[value < 0 && SLIDES[at] && !isShown(SLIDES[at].setting) ? at : at + Number(value)];

// Whether a number has a slider that moves something now.
function moves(name) {
  const known = { alpha: usesAlpha(state.sheet), prisms: ["single", "detailed"].includes(state.sheet), z1: true, z2: true, ...(state.level === "simple" ? { pupil: false, focus: false } : {}) };
  return Boolean($(`slider-${name}`)) && (known[name] ?? partsShown().includes(name));
}

// Where Present is in the lesson: what is shown there, and which slider. The last number of a setting is what it is about.
export function drawPlace() {
  const isOn = document.body.classList.contains("present"), slide = isOn && !linked ? SLIDES[at] : undefined, shown = Boolean(slide) && isShown(slide.setting);
  const { question, sheet = OPENING.sheet, ...numbers } = (isOn && (linked ?? slide?.setting)) || {};
  document.body.classList.toggle("stepping", shown);
  session.about = !question && sheet === state.sheet ? Object.keys(numbers).findLast(moves) ?? "" : "";
  document.body.dataset.about = session.about;
  $("lesson-name").hidden = !slide || question || state.question >= 0;
  $("lesson-name").style.visibility = isToBeFound() ? "hidden" : "";  // it keeps its room
  $("lesson-name").classList.toggle("changed", !shown);
  write("lesson-name", slide && !question ? slide.called() : "");
  write("lesson-place", `${at < 0 ? "–" : at + 1}/${SLIDES.length}`);
  for (const button of steppers) button.disabled = !stepTo(button);
}

// The name of a setting that has none.
function inNumbers(setting) {
  const { sheet = OPENING.sheet, light } = setting;
  const numbers = Object.keys(setting).filter((name) => name in SYMBOL).map((name) => `${SYMBOL[name]} = ${quantity(name, Number(setting[name]))}`);
  return [say(`kinds.${sheet}.choice`), ...numbers, ...(light ? [say(`light.show.${light}`)] : [])].join(", ");
}

const settingLink = ({ setting, called }) => element("a", { href: page() + hashOf(setting), textContent: called(), onclick: () => opens(setting) });

// A lesson: the minutes of its steps, what the page shows in each, and the questions that it asks. Or a gallery, without minutes.
function lessonTable(lesson) {
  const { title, steps: titles, believed = [] } = entry(`lessons.${lesson.name}`), settings = stepsOf(lesson);
  let minute = 0;
  const rows = lesson.steps.map(({ minutes }, k) => {
    const from = minute;
    minute += minutes ?? 0;
    return element("tr", {},
      element("td", { textContent: minutes ? `${from}–${minute}` : "" }),
      element("td", {}, element("b", { textContent: titles[k] }), ...(believed[k] ? [element("p", { textContent: say("teaching.believed", { what: believed[k] }) })] : []),
        element("ul", {}, ...settings[k].map((each) => element("li", {}, settingLink(each))))));
  });
  const heads = ["minutes", "step"].map((head) => element("th", { scope: "col", textContent: say(`teaching.${head}`) }));
  return [element("h2", { textContent: title }), element("p", { textContent: say("teaching.lesson_help") }),
    element("table", {}, element("thead", {}, element("tr", {}, ...heads)), element("tbody", {}, ...rows))];
}

function drawLessons() {
  $("lessons").replaceChildren(...data.lessons.flatMap(lessonTable));
  const named = ({ name }) => (data.lessons.length > 1 ? `: ${entry(`lessons.${name}.title`)}` : "");
  $("print-tasks").replaceChildren(...data.lessons.map((lesson) => element("button", { type: "button", textContent: say("teaching.print") + named(lesson), onclick: () => {
    $("teach").close();
    document.body.classList.add("tasks");
    printPicture(() => drawTasks(lesson));
  } })));
}

// A picture without glasses, and as large as it is printed, also where the page shows the light in its place. For measuring, it has
// what is drawn on it but its numbers.
async function taskPicture(scene, isMeasured = false) {
  if (!view.gl || view.gl.isContextLost()) return "";
  view.set({ ...scene, eyes: 0 });
  const canvas = still(view, 960, Math.round((960 * view.canvas.height) / view.canvas.width));
  if (isMeasured) {
    const pen = canvas.getContext("2d");
    drawOther(pen, canvas, true);
    pen.drawImage(await overlayImage(canvas, false), 0, 0);
  }
  refresh();
  return canvas.toDataURL();
}

const blank = (label) => element("span", { className: "blank", innerHTML: marked(label) });

// The first page asks, with the empty window, and the second one, which shows what the page shows, would answer.
async function drawTasks({ steps }) {
  const own = QUESTIONS.filter((question) => question.own), questions = own.length ? own : steps.flatMap(({ asks }) => asks).map(asked);
  const tasks = questions.map((question) => {
    const boxes = (choices(question) ?? ["……"]).map((choice) => element("span", { textContent: `☐ ${choice}` }));
    return element("li", {}, element("p", { textContent: unbroken(ask(question)) }), element("p", { className: "boxes" }, ...boxes));
  });
  $("task-list").replaceChildren(...tasks);
  $("task-name").replaceChildren(blank(say("teaching.name")), blank(say("teaching.date")));
  $("task-setting").textContent = settingSaid(moment());
  const now = moment(), { nu, turned = nu, sheet } = now;
  $("task-pictures").hidden = sheet === "none";  // page 1 has it
  for (const part of document.querySelectorAll(".measured")) part.hidden = ["none", "single"].includes(sheet) || !Number.isFinite(turned);
  $("task-measured").replaceChildren(...["<i>ν</i> =", `${say("page.size")} =`].map(blank));
  $("task-picture").src = await taskPicture(now.scene, true);
  $("task-free").src = await taskPicture(otherScene(now, "none"));
  $("task-asks").src = await taskPicture(MOMENTS.free_start(questions[0] ?? {}, (values) => found(values, ({ scene }) => scene)));
  $("task-code").hidden = !drawCode($("task-code").firstElementChild);
  $("task-address").textContent = location.host ? page() : "";
}

$("teach-open").addEventListener("click", () => {
  drawLessons();
  $("teach").showModal();
});
$("teach").addEventListener("click", ({ target }) => {
  const leads = target.closest("a");
  if (leads || target === $("teach")) $("teach").close();
  // the page shows what the link leads to in the next frame
  if (leads) requestAnimationFrame(() => requestAnimationFrame(() => $(state.question < 0 ? "sentence" : "ask").focus()));
});
addEventListener("afterprint", () => document.body.classList.remove("tasks"));
function lead(button) {
  const { setting } = stepTo(button);
  opens(setting);
  location.hash = hashOf(setting);
}
for (const button of steppers) button.addEventListener("click", () => lead(button));
// Where the page is in the lesson, also if an address has led there. One that is not of the lesson keeps its place. If the page has
// not written this address itself, with all numbers, it says which number it is about.
export function locate(address = "") {
  const place = SLIDES[at] && isShown(SLIDES[at].setting) ? at : SLIDES.findIndex(({ setting }) => isShown(setting));
  const given = new URLSearchParams(address.slice(1));
  linked = place < 0 && address ? (given.has("diagram") ? {} : Object.fromEntries(given)) : null;
  if (place >= 0) at = place;
  inTab("lesson", String(at));
}
// The lesson begins with its first step: at once, if nothing has been set.
on("present", "click", () => {
  locate();
  if (!isShown({})) return;
  at = -1;
  lead(steppers[1]);
});
// A presenter's remote control sends the first two keys. The others move what has the focus, if it can be moved.
document.addEventListener("keydown", (event) => {
  const way = { PageUp: 0, PageDown: 1, ...(event.target.matches("body, button") ? { ArrowLeft: 0, ArrowRight: 1 } : {}) }[event.key];
  if (way === undefined || event.defaultPrevented || event.altKey || event.ctrlKey || event.metaKey) return;
  if (!document.body.classList.contains("present") || event.target.matches("textarea")) return;
  event.preventDefault();
  steppers[way].click();
});
