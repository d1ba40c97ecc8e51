// The panel of the questions: a class predicts and votes, and the page then shows the answer. Also a teacher's own questions.

import { hasPiece } from "../liveview/presets.js";
import { coded, fromHash, ownQuestion, settings } from "./address.js";
import { $, element, on, pick, refresh, write } from "./data.js";
import { keep, saveTable, work } from "./kept.js";
import { entry, percent, printed, say, typedNumber, unbroken } from "./language.js";
import { compared, dashedOutline, matching, misfit, numbersOf } from "./overlay.js";
import { player, reducedMotion } from "./player.js";
import { ask, choices, end, fillsWindow, isAsked, isRevealed, isRight, MOST_CHOICES, nameOf, ownQuestions, prediction, QUESTIONS, reason, rememberQuestion, why, worked } from "./questions.js";
import { change, LOOKER, OPENING, session, state, SWITCHES, WHOLE } from "./state.js";

// Open a question. -1 goes back to what has been explored.
export function openQuestion(n) {
  if (n === state.question) return;
  kept = null;
  player.pause();
  endGlide();
  if (state.question < 0) session.explored = { ...state };
  session.replaced = null;
  if (n >= 0) {
    rememberQuestion(n);
    showQuestion(n);
  } else {
    change({ ...session.explored, ...pick(state, ...LOOKER), question: -1 });
  }
  drawQuestion();
  refresh();
}

// Show a question as before its answer.
export function askAnew(n) {
  const answer = work.answers[QUESTIONS[n].name];
  if (answer) answer.shown = false;
  keep();
  showQuestion(n, state);
}

// Show a question, with its answer if that has been revealed. `own`: how the picture and the diagram are drawn.
function showQuestion(n, own = session.explored ?? OPENING) {
  endGlide();
  drawnQuestion = null;
  session.drawn = null;
  change({ ...pick(own, "diagram", ...SWITCHES), ...(isRevealed(n) ? end(QUESTIONS[n]) : QUESTIONS[n].before), ...pick(state, ...LOOKER), question: n });
}

let refused = "";  // why what was typed is no answer

const made = () => /** @type {string | null} */ (new FormData($("question-form")).get("prediction"));

// Keep the prediction, and go to what the question is about: from its premise, whatever has been changed since. A challenge that
// is done stays as it is.
export function reveal(done = false) {
  const question = QUESTIONS[state.question];
  const found = () => (question.match ? misfit(question) : String(done));
  const given = question.goal || question.match ? (done || isTried(question) ? found() : null) : made()?.trim() || null;
  session.drawn = question.match || question.goal ? null : session.dashed;
  work.answers[question.name] = { first: given === null ? null : isRight(question, given), ...work.answers[question.name], given, shown: true };
  keepOwn(question);
  if (!done) glide(end(question));
}

const isTried = ({ match, before }) => Object.keys(match ?? {}).some((name) => state[name] !== before[name]);

// Whether there is something to check: a choice, a number, or a setting that was changed.
const isToCheck = (question) => (question.match ? isTried(question) : !question.goal && Boolean(made()?.trim()));
$("question-form").addEventListener("input", refresh);

// Keep the work, with the texts of a teacher's own question.
function keepOwn({ own, name }) {
  if (own) work.own[name] = pick(own, "ask", "choices");
  keep();
}

// A challenge is done when the settings rest where its goal is.
let resting = 0;
function notice(question) {
  const holds = () => question?.goal && !player.playing && question === QUESTIONS[state.question] && isAsked() && question.goal();
  clearTimeout(resting);
  if (holds()) resting = setTimeout(() => {
    if (!holds()) return;
    reveal(true);
    refresh();
  }, 700);
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
  const between = (a, b, part) => (Array.isArray(b) ? b.map((x, k) => between(a[k], x, part)) : typeof b === "number" ? a + (b - a) * part : b);
  const rounded = (name, x) => (WHOLE.includes(name) ? Math.round(x) : x);
  const tick = () => {
    const time = reducedMotion.matches ? 1 : Math.min(1, (performance.now() - start) / 1500);
    const part = time * time * (3 - 2 * time);
    if (session.gliding !== target) return;
    change(Object.fromEntries(Object.entries(target).map(([name, to]) => [name, time < 1 ? rounded(name, between(from[name], to, part)) : to])));
    refresh();
    if (time < 1) requestAnimationFrame(tick);
    else session.gliding = null;
  };
  tick();
}

// ---- The panel ----

let drawnQuestion = null;
let fills = false;  // whether a point of the piece fills the window at its end: no outline can say that
/** @type {any} */
let kept = null;  // a prediction and its question, while the panel is written anew
const NOT_TURNED = ["single", "mirror", "lenticular"];  // sheets whose picture is not the object, turned and sized

// The numbers of the questions of this level, and of the one that is open. A teacher's own are on their own.
const offered = () => {
  const own = (question) => Boolean(question.own), isOwn = own(QUESTIONS[state.question]);
  return [...QUESTIONS.keys()].filter((n) => own(QUESTIONS[n]) === isOwn && (n === state.question || state.level === "expert" || !QUESTIONS[n].expert));
};

// The panel is written anew, because the language has changed, or when its question is open again.
export function rewriteQuestion() {
  if (drawnQuestion) kept = { question: drawnQuestion, made: made() };
  drawnQuestion = null;
}

export function drawQuestion() {
  const n = state.question;
  notice(QUESTIONS[n]);
  if (n < 0) {
    session.dashed = null;
    if ($("ask-diagram").contains($("diagram-box"))) moveDiagram();
    return (drawnQuestion = null);
  }
  const question = QUESTIONS[n];
  if (question !== drawnQuestion) {
    $("ask").textContent = unbroken(ask(question));
    $("prediction").replaceChildren(...(question.match || question.goal ? [] : choices(question)?.map(choiceInput) ?? [numberInput(question)]));
    drawVotes(question);
    if (kept?.question !== question) for (const what of ["turn", "size"]) $(`draw-${what}`).value = 0;
    if (isRevealed(n) && work.votes[question.name]) $("votes").hidden = false;
    drawnQuestion = question;
    refused = "";
    fills = fillsWindow(question);
  }
  $("question-count").textContent = say("asking.count", { n: offered().indexOf(n) + 1, count: offered().length });
  const tries = offered().map((k) => work.answers[QUESTIONS[k].name]?.first).filter((first) => typeof first === "boolean");
  write("score", tries.length ? say("asking.score", { right: tries.filter(Boolean).length, count: tries.length }) : "");
  const shown = isRevealed(n);
  $("reveal").hidden = shown;
  $("again").hidden = !shown;
  $("own-remove").hidden = !question.own;
  const open = (id) => !$(id).hidden;
  $("other-questions").hidden = !ownQuestions().length;
  $("other-questions").textContent = say(`asking.${question.own ? "to_page" : "to_link"}`);
  aid("votes").hidden = !choices(question);
  const last = question.after.sheet ?? question.before.sheet;
  const isOfMountains = Boolean(entry(`questions.${question.name}.says`));
  const isOfEye = String(question.after.E ?? question.before.E) !== String(question.before.E);  // then the piece moves
  aid("drawing").hidden = isOfMountains || isOfEye || Boolean(question.match || question.goal) || !hasPiece(state.scene) || NOT_TURNED.includes(last) || fills;
  for (const button of document.querySelectorAll("#aids [aria-controls]")) {  // a part without its button could not be closed
    const part = $(button.getAttribute("aria-controls"));
    if (button.hidden || (button.dataset.level && state.level === "simple")) part.hidden = true;
    button.setAttribute("aria-expanded", String(!part.hidden));
  }
  if (open("ask-diagram") !== $("ask-diagram").contains($("diagram-box"))) moveDiagram();
  session.dashed = dashedOutline(question, open("drawing"));
  for (const input of $("prediction").querySelectorAll("input")) {
    input.disabled = shown;
    const given = prediction(n) ?? (kept?.question === question ? kept.made : null);
    if (given && input.type === "radio") input.checked = input.value === given;
    else if (given) input.value = given;
    const isChoice = shown && input.type === "radio", isRightOne = Number(input.value) === question.answer();
    input.parentNode.classList.toggle("right", isChoice && isRightOne);
    input.parentNode.classList.toggle("wrong", isChoice && !isRightOne && input.checked);
  }
  kept = null;
  write("reveal", say(`asking.${isToCheck(question) ? "check" : "reveal"}`));
  const said = element("p", {}, ...(shown ? answerText(question, prediction(n)) : [refused]));
  if (said.textContent !== $("answer").textContent) $("answer").replaceChildren(...said.childNodes);  // a screen reader speaks it once
  write("drawn-answer", shown && session.drawn && !session.gliding ? compared(session.drawn) : "");
  $("previous").disabled = n === offered().at(0);
  $("next").disabled = n === offered().at(-1);
}

// ---- What helps with a question: each button opens and closes a part ----

const aid = (id) => document.querySelector(`#aids [aria-controls="${id}"]`);
for (const button of document.querySelectorAll("#aids [aria-controls]")) {
  button.addEventListener("click", () => {
    const part = $(button.getAttribute("aria-controls"));
    part.hidden = !part.hidden;
    drawQuestion();
    part.scrollIntoView({ block: "nearest" });
    refresh();
  });
}

// The diagram is in one of two panels.
function moveDiagram() {
  if (state.question >= 0 && !$("ask-diagram").hidden) $("ask-diagram").append($("diagram-box"));
  else $("explore").insertBefore($("diagram-box"), document.querySelector("#explore dl"));
}

for (const id of ["draw-turn", "draw-size"]) $(id).addEventListener("input", refresh);

const choiceInput = (text, value) => element("label", {}, element("input", { type: "radio", name: "prediction", value }), text);
const numberInput = ({ name, tolerance }) => element("label", {}, element("input", { className: "field", autocomplete: "off", name: "prediction" }),
  ` ${say("asking.within", { unit: say(`questions.${name}.unit`), tolerance: printed(String(tolerance)) })}`);

// Whether the class is right, the answer, and why.
function answerText(question, given) {
  if (question.goal) return [element("strong", {}, say(`asking.${given === "true" ? "done" : "one_way"}`)), ` ${why(question)}`];
  if (question.match) return [element("strong", {}, say(`asking.${given === "true" ? "matched" : "not_matched"}`, numbersOf(matching(question)))), ...reasons(question, given)];
  const right = question.answer();
  const number = question.tolerance && printed(String(Number(right.toFixed(Math.max(1, -Math.floor(Math.log10(question.tolerance)))))));
  const answer = choices(question)?.[right] ?? say("asking.value", { number, unit: say(`questions.${question.name}.unit`) });
  const said = say(`asking.${given ? (isRight(question, given) ? "yes" : "no") : "answer"}`, { answer });
  return [element("strong", {}, said[0].toUpperCase() + said.slice(1)), ...reasons(question, given)];
}
const reasons = (question, given) => [reason(question, given), why(question)].filter(Boolean).map((text) => ` ${text}`);

// Why a text is no answer to a question that asks for a number; "" if it is one.
function refusal({ unit }, text) {
  const { x, units, other } = typedNumber(text);
  if (other || (units.length && !units.includes(unit))) return say("asking.unit", { text, unit: say(`units.${unit}`) });
  return Number.isFinite(x) ? "" : say("asking.number_first");
}

$("question-form").addEventListener("submit", (event) => {
  event.preventDefault();
  if (!isAsked()) return;  // the panel shows a question that has been left, until the page is drawn
  const field = $("prediction").querySelector(".field");
  refused = field?.value.trim() ? refusal(QUESTIONS[state.question], field.value) : "";
  if (!refused) reveal();
  drawQuestion();
  if (refused) field.focus();
  else {
    ["next", "previous", "lesson-next"].map($).find((button) => !button.disabled && button.checkVisibility())?.focus();  // the button Reveal is gone
    $("answer").scrollIntoView({ block: "nearest" });
  }
});
$("again").addEventListener("click", () => {
  if (state.question < 0 || isAsked()) return;
  askAnew(state.question);
  drawQuestion();
  refresh();
  $("ask").focus();
});

function goTo(n) {
  if (state.question < 0) return;
  openQuestion(n);
  $("ask").focus();
}
for (const [id, aside] of Object.entries({ previous: -1, next: 1 })) $(id).addEventListener("click", () => goTo(offered()[offered().indexOf(state.question) + aside]));
// Whether a question has been answered, and rightly.
function mark(question) {
  const answer = work.answers[question.name];
  return !answer ? "" : answer.given === null ? "– " : isRight(question, answer.given) ? "✓ " : "✗ ";
}
const list = $("question-list");
list.addEventListener("beforetoggle", ({ newState }) => newState === "open" && list.replaceChildren(...offered().map((n) => {
  const open = () => {
    list.hidePopover();
    goTo(n);
  };
  return element("li", {}, element("button", { type: "button", textContent: `${mark(QUESTIONS[n])}${ask(QUESTIONS[n])}`, ariaCurrent: String(n === state.question), onclick: open }));
})));

on("other-questions", "click", () => openQuestion(QUESTIONS.findIndex(({ own }) => Boolean(own) !== Boolean(QUESTIONS[state.question].own))));

// ---- The votes of a class, before and after it has discussed a question: a number for each choice, and bars ----

function drawVotes(question) {
  const offers = choices(question), none = () => offers.map(() => 0);
  if (!offers) return $("votes").replaceChildren();
  const rounds = work.votes[question.name] ?? [none()], given = rounds.at(-1);
  const count = () => {
    work.votes[question.name] = rounds;
    keepOwn(question);
    refresh();
  };
  const rows = offers.map((choice, k) => {
    const field = element("input", { type: "number", min: 0, max: 999, value: given[k], className: "field", ariaLabel: say("asking.votes_for", { choice }) });
    field.addEventListener("focus", () => field.select());  // what is typed replaces the 0
    field.addEventListener("input", () => {
      given[k] = Math.max(0, Math.round(Number(field.value)) || 0);
      show();
      count();
    });
    const bars = rounds.map(() => element("i")), share = element("output", { ariaLive: "off" });  // the field says the number
    return { row: element("label", {}, element("span", {}, choice), field, element("span", { className: "track" }, ...bars), share), bars, share };
  });
  const show = () => {
    again.disabled = rounds.length > 1 && rounds[1].some(Boolean);
    rows.forEach(showRow);
  };
  const showRow = ({ bars, share }, k) => {
    const shares = rounds.map((round) => round[k] / round.reduce((sum, x) => sum + x, 0));  // NaN before anybody votes
    bars.forEach((bar, m) => (bar.style.width = `${100 * (shares[m] || 0)}%`));
    share.textContent = rounds.flat().some(Boolean) ? shares.map((x) => (Number.isNaN(x) ? "–" : percent(x))).join(" → ") : "";
  };
  const again = element("button", { type: "button", textContent: say("asking.vote_again"), ariaPressed: String(rounds.length > 1) });
  again.addEventListener("click", () => {
    // pressed again before anybody has voted: it was pressed by mistake
    if (rounds.length > 1) rounds.pop();
    else rounds.push(none());
    count();
    drawVotes(question);
    $("votes").querySelector("input").focus();
  });
  $("votes").replaceChildren(...rows.map(({ row }) => row), again);
  show();
}
// In a field for votes, Enter would reveal the answer.
$("votes").addEventListener("keydown", (event) => event.key === "Enter" && event.target.type === "number" && event.preventDefault());

// What a class has voted and answered: a row for each choice, or for the number that was typed.
export function answersTable() {
  const head = ["question", "text", "answer", "right_answer", "votes", "votes_again", "predicted", "right_at_first"];
  const rows = worked().flatMap((question) => {
    const { first, given } = work.answers[question.name] ?? {}, [votes = [], again = []] = work.votes[question.name] ?? [];
    const row = (text, k, made) => [question.name, ask(question), text, Number(isRight(question, k)), votes[k], again[k], Number(made), made && first !== null ? Number(first) : undefined];
    return choices(question)?.map((text, k) => row(text, String(k), given === String(k))) ?? [row(question.match && given ? String(given === "true") : given ?? "", given ?? "", Boolean(given))];
  });
  return [head, ...rows];
}
$("save-answers").addEventListener("click", () => saveTable("povgen-answers.csv", answersTable()));

// ---- Questions of a teacher's own, in a link ----

const views = { before: null, after: null };  // the settings that the page shows first, and with the answer

const PARTS = { start: "before", end: "after" };
for (const [id, part] of Object.entries(PARTS)) {
  $(`own-${id}`).addEventListener("click", () => {
    views[part] = settings();
    $(`own-${id}`).setAttribute("aria-pressed", true);
    $("own-message").textContent = "";
  });
}

// Open one of these questions, or leave the questions if there are none.
function openOwn(questions, opened) {
  openQuestion(-1);
  fromHash(`#level=${state.level}&question=${opened ? nameOf(opened) : ""}&own=${coded(questions)}`);
  refresh();
  if (opened) $("ask").focus();
}

$("own").addEventListener("input", () => ($("own-message").textContent = ""));
$("own").addEventListener("submit", (event) => {
  event.preventDefault();
  const lines = (id) => $(id).value.split("\n").map((line) => line.trim()).filter(Boolean);
  const texts = { ask: lines("own-text").join(" "), choices: lines("own-choices"), why: lines("own-why").join(" ") };
  const complete = texts.ask && texts.choices.length > 1 && texts.choices.length <= MOST_CHOICES;
  const lacks = Object.keys(PARTS).find((id) => !views[PARTS[id]]);
  if (!complete || lacks) {
    $(complete ? `own-${lacks}` : "own-text").focus();
    $("own-message").textContent = complete ? say("asking.own_help") : say("asking.own_missing", { most: MOST_CHOICES });
    $("own-message").scrollIntoView({ block: "nearest" });
    return;
  }
  $("own-message").textContent = "";
  const question = ownQuestion(texts, views.before, views.after);
  delete work.answers[nameOf(question)];  // the same one is asked anew
  keep();
  openOwn([...ownQuestions().filter(({ ask }) => ask !== texts.ask), question], question);
});
$("own-remove").addEventListener("click", () => {
  const others = ownQuestions().filter((own) => own !== QUESTIONS[state.question].own);
  openOwn(others, others.at(-1));
});
