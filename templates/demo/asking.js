// The panel of the questions: a class predicts, and the page then shows the answer.

import { SWITCHES } from "./address.js";
import { $ } from "./data.js";
import { refresh } from "./frame.js";
import { printed, readNumber } from "./numbers.js";
import { player, reducedMotion } from "./player.js";
import { QUESTIONS, revealed } from "./questions.js";
import { change, session, state } from "./state.js";

// Open a question with what the page shows before its answer. -1 goes back to what has been explored.
export function openQuestion(n) {
  if (n === state.question) return;
  player.pause();
  endGlide();
  if (state.question < 0) session.explored = { ...state };
  session.replaced = null;
  if (n >= 0) {
    session.lastQuestion = n;
    ask(n);
  } else {
    const shows = Object.fromEntries(["diagram", ...SWITCHES].map((name) => [name, state[name]]));
    change({ ...session.explored, ...shows, question: -1 });
  }
  drawQuestion();
  refresh();
}

// Show a question as before its answer.
function ask(n) {
  endGlide();
  revealed.delete(n);
  drawnQuestion = -1;
  change({ ...QUESTIONS[n].before, question: n });
}

let asksForNumber = false;

// Keep the prediction, and go to what the question is about: from its premise, whatever has been changed since.
export function reveal() {
  const { before, after } = QUESTIONS[state.question];
  revealed.set(state.question, new FormData($("question-form")).get("prediction"));
  glide({ ...before, ...(typeof after === "function" ? after() : after) });
}

// Any input ends the movement: the page is then at its end.
export function endGlide() {
  if (!session.gliding) return;
  change(session.gliding);
  session.gliding = null;
  refresh();
}
for (const event of ["pointerdown", "keydown", "click", "input", "change"]) document.addEventListener(event, endGlide, true);

// Go to other values: numbers gently, unless motion is to be reduced.
function glide(target) {
  session.gliding = target;
  const start = performance.now();
  const from = Object.fromEntries(Object.keys(target).map((name) => [name, state[name]]));
  const numeric = (x) => typeof x === "number" || Array.isArray(x);
  const mixed = (a, b, part) => (Array.isArray(a) ? a.map((x, k) => mixed(x, b[k], part)) : a + (b - a) * part);
  const tick = () => {
    const time = reducedMotion.matches ? 1 : Math.min(1, (performance.now() - start) / 1500);
    const part = time * time * (3 - 2 * time);
    if (session.gliding !== target) return;
    change(Object.fromEntries(Object.entries(target).map(([name, to]) => [name, numeric(to) && time < 1 ? mixed(from[name], to, part) : to])));
    refresh();
    if (time < 1) requestAnimationFrame(tick);
    else session.gliding = null;
  };
  tick();
}

// ---- The panel ----

let drawnQuestion = -1;

export function drawQuestion() {
  const n = state.question;
  if (n < 0) return (drawnQuestion = -1);
  const question = QUESTIONS[n];
  if (n !== drawnQuestion) {
    $("question-count").textContent = `Question ${n + 1} of ${QUESTIONS.length}`;
    $("ask").textContent = question.ask.replaceAll(" = ", "\u00a0=\u00a0");  // not parted at a line's end
    $("prediction").replaceChildren(...(question.choices ? question.choices.map(choiceInput) : [numberInput(question)]));
    drawnQuestion = n;
    asksForNumber = false;
  }
  $("reveal").hidden = revealed.has(n);
  $("again").hidden = !revealed.has(n);
  for (const input of $("prediction").querySelectorAll("input")) {
    input.disabled = revealed.has(n);
    const made = revealed.get(n);
    if (made && input.type === "radio") input.checked = input.value === made;
    else if (made) input.value = made;
  }
  const said = document.createElement("p");
  said.append(...(revealed.has(n) ? answerText(question) : asksForNumber ? ["Type a number first."] : []));
  if (said.textContent !== $("answer").textContent) $("answer").replaceChildren(...said.childNodes);  // a screen reader speaks it once
  $("previous").disabled = n === 0;
  $("next").disabled = n === QUESTIONS.length - 1;
}

function choiceInput(text, k) {
  const label = document.createElement("label");
  const input = Object.assign(document.createElement("input"), { type: "radio", name: "prediction", value: k });
  label.append(input, text);
  return label;
}

function numberInput({ unit, tolerance }) {
  const label = document.createElement("label");
  const input = Object.assign(document.createElement("input"), { className: "field", autocomplete: "off", name: "prediction" });
  label.append(input, ` ${unit}, within ${tolerance}`);
  return label;
}

// Whether the class is right, the answer, and why.
function answerText(question) {
  const right = question.answer();
  const given = revealed.get(QUESTIONS.indexOf(question));
  const isRight = question.choices ? Number(given) === right : Math.abs(readNumber(given) - right) <= question.tolerance;
  const verdict = given ? (isRight ? "Yes: " : "No: ") : "";
  const text = question.choices ? question.choices[right] : `${printed(String(Number(right.toPrecision(4))))} ${question.unit}`;
  const said = verdict ? verdict + text : text[0].toUpperCase() + text.slice(1);
  const strong = Object.assign(document.createElement("strong"), { textContent: `${said}.` });
  return [strong, ` ${question.why()}`];
}

$("question-form").addEventListener("submit", (event) => {
  event.preventDefault();
  const field = $("prediction").querySelector(".field");
  asksForNumber = Boolean(field) && !Number.isFinite(readNumber(field.value));
  if (!asksForNumber) reveal();
  drawQuestion();
  if (asksForNumber) field.focus();
  else ($("next").disabled ? $("previous") : $("next")).focus();  // the button Reveal is gone
});
$("again").addEventListener("click", () => {
  ask(state.question);
  drawQuestion();
  refresh();
  $("ask").focus();
});
for (const [id, aside] of Object.entries({ previous: -1, next: 1 })) {
  $(id).addEventListener("click", () => {
    openQuestion(state.question + aside);
    $("ask").focus();
  });
}
