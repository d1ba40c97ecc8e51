// The guided start: it moves by itself, step by step, can be left at any time and run again. With reduced motion each step waits for
// the button.

import { radians } from "../liveview/geometry.js";
import { SWITCHES } from "./address.js";
import { rewriteQuestion } from "./asking.js";
import { minus, plus, scaled, times, turn } from "./complex.js";
import { $, on, pick, refresh } from "./data.js";
import { entry, say } from "./language.js";
import { view } from "./picture.js";
import { player, reducedMotion } from "./player.js";
import { CAMERAS } from "./space.js";
import { change, LOOKER, OPENING, session, START, state } from "./state.js";

const KNIGHT = { ...OPENING, ...START.chess, prisms: 100, sheet: "ideal" };
// The page opens with it: the effect, beside what there is. The poster is its first picture (page.py).
const INTRO = { shows: { z1: 3 }, moves: { alpha: [90, 0] }, twin: 3.1, seconds: 8 };
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
  intro: false,  // whether this is not yet the first step

  get now() {
    return this.intro ? INTRO : STEPS[this.step];
  },

  start(asked = false) {
    player.pause();
    this.before ??= { state: { ...state }, measuring: session.measuring };
    session.measuring = false;
    rewriteQuestion();  // a prediction that has been made comes back with its question
    Object.assign(this, { asked, paused: reducedMotion.matches });
    this.go(0, !asked);
  },

  go(n, intro = false) {
    if (n >= STEPS.length) return this.leave();
    const running = this.step >= 0;
    Object.assign(this, { step: n, intro });
    this.passed = this.paused ? this.now.seconds : 0;  // who goes from step to step sees where each one ends
    [session.camera, session.zoom] = [CAMERAS.corner, 1];
    this.show();
    if (!running) this.run(performance.now());
  },

  // Show the present step: what moves is at rest in the first and the last fifth.
  show() {
    const { shows, moves = {}, through, twin = 0, seconds } = this.now;
    const part = Math.min(1, Math.max(0, (this.passed / seconds - 0.2) / 0.6));
    const between = (name, from, to) => (name === "alpha" ? from + (to - from) * part : from * (to / from) ** part);
    const moved = Object.entries(moves).map(([name, [from, to]]) => [name, between(name, from, to)]);
    const values = { ...KNIGHT, ...pick(state, ...LOOKER), ...shows, ...Object.fromEntries(moved) };
    if (through) values.L = plus(through, scaled(values.z1 / values.z2, times(turn(-radians(values.alpha)), minus(through, values.E))));
    change(values);
    session.twin = twin;
    refresh();
  },

  // Go to the next step.
  next() {
    this.go(this.intro ? 0 : this.step + 1);
  },

  run(last) {
    requestAnimationFrame((time) => {
      if (this.step < 0) return;
      if (!this.paused) {
        if (!view.behind) this.passed += Math.min(0.5, Math.max(0, (time - last) / 1000));
        if (this.passed < this.now.seconds) this.show();
        else if (this.step < STEPS.length - 1) this.next();
      }
      this.run(time);
    });
  },

  isStill() {
    return this.step >= 0 && (this.paused || this.passed > 0.8 * this.now.seconds);
  },

  // What a screen reader speaks of this step.
  says: () => [say("tour.begun"), tour.text()],
  text: () => (tour.intro ? say("tour.intro") : entry("tour.steps")[tour.step]),

  seconds: () => STEPS.reduce((sum, { seconds }) => sum + seconds, 0),

  // Go back to what the page showed before; or stay, where someone has taken over. The view of the light is `kept` too, if it is this
  // that they use.
  leave(stay = false, kept = false) {
    if (this.step < 0) return;
    this.step = -1;
    session.twin = 0;
    if (!stay) session.measuring = this.before.measuring;
    if (!kept) change(stay ? pick(this.before.state, "light", "diagram", ...SWITCHES) : this.before.state);
    this.before = null;
    document.body.classList.remove("begins");  // the poster shows its first picture
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
    if (!on) return;
    $("tour-text").textContent = this.text();
    $("tour-count").textContent = this.intro ? "" : say("tour.count", { n: this.step + 1, count: STEPS.length });
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
$("tour-next").addEventListener("click", () => tour.next());
on("tour-pause", "click", () => (tour.paused = !tour.paused));
$("tour-leave").addEventListener("click", () => tour.leave());

// Whoever moves something else takes over. A panel, also the teacher's, begins with what the page showed before, and a language moves nothing.
const taken = ({ target }) => {
  if (tour.step >= 0 && !target.closest?.("#tour, #tour-start, #space-turn, #cameras, #language, footer details")) tour.leave(!target.closest?.("[role=tab], #teach-open"), Boolean(target.closest?.("#space-box")));
};
for (const event of ["input", "change"]) document.addEventListener(event, taken, true);
// What is pressed is where it was until it is released: without the guided start, parts of the page have other places.
for (const [event, parts] of [["pointerdown", "#stage, [type=range]"], ["click", "#stage, button, input, select"]]) {
  document.addEventListener(event, (what) => what.target.closest?.(parts) && taken(what), true);
}
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
