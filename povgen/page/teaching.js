// A teacher's panel: what such windows are good for, the steps of a lesson, and a sheet of tasks to print.

import { lasting } from "./address.js";
import { $, element } from "./data.js";
import { drawCode, page, printed, printPicture } from "./handouts.js";
import { keep, work } from "./kept.js";
import { entry, marked, quantity, say, SYMBOL, unbroken } from "./language.js";
import { moment } from "./moment.js";
import { ask, choices, QUESTIONS } from "./questions.js";
import { settingSaid } from "./text.js";

// The steps of the lesson: their minutes, what the page shows in each, and the names of the questions that it asks.
const STEPS = [
  { name: "predict", minutes: 5, shows: [{ sheet: "none" }], asks: [] },
  { name: "prism", minutes: 7, shows: [{ sheet: "single", light: "prism", show: "large" }, { sheet: "single" }], asks: ["sky"] },
  { name: "mirrors", minutes: 7, shows: [{ sheet: "ideal", alpha: 0 }], asks: ["near"] },
  { name: "air", minutes: 7, shows: [{ sheet: "ideal", alpha: 180 }, { sheet: "ideal", alpha: 180, light: "pencil", show: "large" }], asks: ["parallax"] },
  { name: "distance", minutes: 14, shows: [{ sheet: "ideal", alpha: 90, z1: 6 }, { sheet: "ideal", alpha: 90, z1: 2 }], asks: ["far"] },
  { name: "say", minutes: 5, shows: [12, 300].map((prisms) => ({ sheet: "detailed", alpha: 66, prisms })), asks: [] },
];
const asked = (name) => QUESTIONS.find((question) => question.name === name);

// A link to a setting of the page, named by the setting, or to a question.
function settingLink(setting) {
  const { sheet, light, question } = setting;
  const numbers = Object.keys(setting).filter((name) => name in SYMBOL).map((name) => `${SYMBOL[name]} = ${quantity(name, setting[name])}`);
  const parts = question ? [ask(asked(question))] : [say(`kinds.${sheet}.choice`), ...numbers, ...(light ? [say(`light.show.${light}`)] : [])];
  const href = `${page()}#${new URLSearchParams({ ...setting, ...lasting() })}`;
  return element("a", { href, textContent: parts.join(", "), onclick: () => {
    if (work.answers[question]) work.answers[question].shown = false;  // it is asked anew
    keep();
  } });
}

function drawLesson() {
  let minute = 0;
  const rows = STEPS.map(({ name, minutes, shows, asks }) => {
    const { title, believed } = entry(`teaching.steps.${name}`);
    const from = minute;
    minute += minutes;
    const links = [...shows, ...asks.map((question) => ({ question }))].map((setting) => element("li", {}, settingLink(setting)));
    return element("tr", {},
      element("td", { textContent: `${from}–${minute}` }),
      element("td", {}, element("b", { textContent: title }), ...(believed ? [element("p", { textContent: say("teaching.believed", { what: believed }) })] : []), element("ul", {}, ...links)));
  });
  $("lesson-steps").replaceChildren(...rows);
}

const blank = (label) => element("span", { className: "blank", innerHTML: marked(label) });

function drawTasks() {
  const tasks = STEPS.flatMap(({ asks }) => asks).map(asked).map((question) => {
    const boxes = choices(question).map((choice) => element("span", { textContent: `☐ ${choice}` }));
    return element("li", {}, element("p", { textContent: unbroken(ask(question)) }), element("p", { className: "boxes" }, ...boxes));
  });
  $("task-list").replaceChildren(...tasks);
  $("task-name").replaceChildren(blank(say("teaching.name")), blank(say("teaching.date")));
  $("task-setting").textContent = settingSaid(moment());
  $("task-measured").replaceChildren(...["<i>ν</i> =", "<i>M</i> ="].map(blank));
  $("task-picture").src = printed.src;
  $("task-code").hidden = !drawCode($("task-code").firstElementChild);
  $("task-address").textContent = location.host ? page() : "";
}

$("teach-open").addEventListener("click", () => {
  drawLesson();
  $("teach").showModal();
});
$("teach").addEventListener("click", ({ target }) => (target === $("teach") || target.closest("a")) && $("teach").close());
$("print-tasks").addEventListener("click", () => {
  $("teach").close();
  document.body.classList.add("tasks");
  printPicture(drawTasks);
});
addEventListener("afterprint", () => document.body.classList.remove("tasks"));
