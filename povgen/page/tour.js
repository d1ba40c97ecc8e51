// The guided start: it moves by itself, step by step, can be left at any time and run again. With reduced motion each step waits for
// the button.

import { radians } from "../liveview/geometry.js";
import { rewriteQuestion } from "./asking.js";
import { minus, plus, scaled, times, turn } from "./complex.js";
import { $, on, refresh } from "./data.js";
import { entry, say } from "./language.js";
import { player, reducedMotion } from "./player.js";
import { change, OPENING, session, START, state } from "./state.js";

const KNIGHT = { ...OPENING, ...START.chess, prisms: 100, sheet: "ideal" };
// What each step shows, what moves in it, from one value to another, the place of the window through which the knight stays to be seen,
// and its length in seconds.
const STEPS = [
  { shows: { sheet: "none" }, seconds: 5 },
  { shows: { sheet: "single", light: "prism", large: true, stray: false }, seconds: 11 },
  { shows: { sheet: "single" }, seconds: 9 },
  { shows: { sheet: "detailed", prisms: 12, large: true, stray: false }, moves: { alpha: [0, 66] }, seconds: 11 },
  { shows: { sheet: "detailed" }, moves: { prisms: [12, 300] }, seconds: 8 },
  { shows: {}, moves: { alpha: [0, 120] }, seconds: 10 },
  { shows: { E: [0, -0.9], large: true }, moves: { z1: [0.6, 12] }, through: [0.3, -0.3], seconds: 15 },
  { shows: {}, moves: { alpha: [120, 180] }, seconds: 7 },
  { shows: { alpha: 180, light: "pencil", large: true }, seconds: 9 },
  { shows: {}, seconds: 5 },
];

export const tour = {
  step: -1, paused: false,
  asked: false,  // whether someone has started it
  passed: 0,     // seconds of this step
  before: null,  // what the page showed

  start(asked = false) {
    player.pause();
    this.before ??= { ...state };
    rewriteQuestion();  // a prediction that has been made comes back with its question
    Object.assign(this, { asked, paused: reducedMotion.matches });
    this.go(0);
  },

  go(n) {
    if (n >= STEPS.length) return this.leave();
    const running = this.step >= 0;
    [this.step, this.passed] = [n, this.paused ? STEPS[n].seconds : 0];  // who goes from step to step sees where each one ends
    [session.camera, session.zoom] = [[0.55, 0.3], 1];
    this.show();
    if (!running) this.run(performance.now());
  },

  // Show the present step: what moves is at rest in the first and the last fifth.
  show() {
    const { shows, moves = {}, through, seconds } = STEPS[this.step];
    const part = Math.min(1, Math.max(0, (this.passed / seconds - 0.2) / 0.6));
    const between = (name, from, to) => (name === "alpha" ? from + (to - from) * part : from * (to / from) ** part);
    const moved = Object.entries(moves).map(([name, [from, to]]) => [name, between(name, from, to)]);
    const values = { ...KNIGHT, level: state.level, ...shows, ...Object.fromEntries(moved) };
    if (through) values.L = plus(through, scaled(values.z1 / values.z2, times(turn(-radians(values.alpha)), minus(through, values.E))));
    change(values);
    refresh();
  },

  run(last) {
    requestAnimationFrame((time) => {
      if (this.step < 0) return;
      if (!this.paused) {
        this.passed += Math.min(0.5, Math.max(0, (time - last) / 1000));
        if (this.passed < STEPS[this.step].seconds) this.show();
        else if (this.step < STEPS.length - 1) this.go(this.step + 1);
      }
      this.run(time);
    });
  },

  isStill() {
    return this.step >= 0 && (this.paused || this.passed > 0.8 * STEPS[this.step].seconds);
  },

  // What a screen reader speaks of this step.
  says: () => [say("tour.begun"), entry("tour.steps")[tour.step]],

  seconds: () => STEPS.reduce((sum, { seconds }) => sum + seconds, 0),

  // Go back to what the page showed before; or stay, where someone has taken over.
  leave(stay = false) {
    if (this.step < 0) return;
    this.step = -1;
    if (!stay) change(this.before);
    this.before = null;
    $("spoken").textContent = say("tour.left");
    const focused = $("tour").contains(document.activeElement);
    this.draw();
    if (focused) $(state.level === "simple" ? "tour-start" : "share-open").focus();
    refresh();
  },

  draw() {
    const on = this.step >= 0;
    document.body.classList.toggle("touring", on);
    $("tour").hidden = !on;
    $("sentence").hidden = on;
    $("tour-start").hidden = on;
    if (!on) return;
    $("tour-text").textContent = entry("tour.steps")[this.step];
    $("tour-count").textContent = say("tour.count", { n: this.step + 1, count: STEPS.length });
    $("tour-pause").textContent = say(this.paused ? "tour.go_on" : "page.pause");
    $("tour-pause").hidden = reducedMotion.matches;
    $("tour-next").textContent = say(this.step === STEPS.length - 1 ? "tour.done" : "asking.next");
  },
};

function begin() {
  tour.start(true);
  tour.draw();
  $("tour-next").focus();  // the button is gone
}
$("tour-start").addEventListener("click", begin);
$("tour-again").addEventListener("click", () => {
  $("share-open").click();  // its sheet closes
  begin();
});
$("tour-next").addEventListener("click", () => tour.go(tour.step + 1));
on("tour-pause", "click", () => (tour.paused = !tour.paused));
$("tour-leave").addEventListener("click", () => tour.leave());

// Whoever moves something else takes over. A panel begins with what the page showed before, and a language moves nothing.
const taken = ({ target }) => {
  if (tour.step >= 0 && !target.closest?.("#tour, #tour-start, #space-turn, #cameras, #language, footer")) tour.leave(!target.closest?.("[role=tab]"));
};
for (const event of ["input", "change"]) document.addEventListener(event, taken, true);
for (const event of ["pointerdown", "click"]) document.addEventListener(event, (what) => what.target.closest?.("#stage, button, input, select") && taken(what), true);
document.addEventListener("keydown", (event) => {
  if (tour.step < 0) return;
  if (event.key === "Escape") tour.leave();
  else if (event.key === "Tab" && !tour.asked) {  // it has begun by itself: it waits, and its buttons come first
    event.preventDefault();
    Object.assign(tour, { asked: true, paused: true });
    tour.draw();
    $("tour-pause").focus();
  } else if (!["Tab", "Enter", " ", "Shift", "Control", "Alt", "Meta", "CapsLock", "Insert"].includes(event.key)) taken(event);
}, true);
