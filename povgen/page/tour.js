// The guided start: it moves by itself, step by step, can be left at any time and run again. With reduced motion each step waits for
// the button.

import { radians } from "../liveview/geometry.js";
import { rewriteQuestion } from "./asking.js";
import { minus, plus, scaled, times, turn } from "./complex.js";
import { shortcut } from "./controls.js";
import { $, data, on, pick, refresh } from "./data.js";
import { inTab } from "./kept.js";
import { entry, isAngle, say } from "./language.js";
import { view } from "./picture.js";
import { player, reducedMotion } from "./player.js";
import { CAMERAS, change, LOOKER, OPENING, session, START, state, SWITCHES } from "./state.js";

const KNIGHT = { ...OPENING, ...START.chess, prisms: 100, sheet: "ideal" };
// Of each tour: what each step shows, what moves in it, from one value to another, the place of the window through which the knight stays to be seen,
// where it stands a second time, and its length in seconds. A tour can begin with an intro: the page opens with that of the first one.
const TOURS = data.tours;

export const tour = {
  which: 0, step: -1, paused: false,
  asked: false,  // whether someone has started it
  byHand: false, // whether someone goes from step to step: then each step waits at its end
  passed: 0,     // seconds of this step
  before: null,  // what the page showed
  intro: false,  // whether this is not yet the first step

  get steps() {
    return TOURS[this.which].steps;
  },
  get ended() {
    return this.passed >= this.now.seconds;
  },
  get waits() {
    return this.byHand && this.ended;
  },
  get isLast() {
    return this.step === this.steps.length - 1;
  },
  get now() {
    return this.intro ? TOURS[this.which].intro : this.steps[this.step];
  },

  start(asked = false, which = 0, step = 0, intro = !asked) {
    player.pause();
    this.before ??= { state: { ...state }, measuring: session.measuring };
    session.measuring = false;
    rewriteQuestion();  // a prediction that has been made comes back with its question
    Object.assign(this, { asked, which, byHand: false, paused: reducedMotion.matches });
    this.go(step, intro);
  },

  go(n, intro = false) {
    if (n >= this.steps.length) return this.leave();
    const running = this.step >= 0;
    Object.assign(this, { step: n, intro });
    inTab("tour", JSON.stringify([this.asked, this.which, n, intro]));  // a page that is loaded again goes on with this step
    this.passed = this.paused ? this.now.seconds : 0;  // who goes from step to step sees where each one ends
    [session.camera, session.zoom] = [CAMERAS.corner, 1];
    this.show();
    if (!running) this.run(performance.now());
  },

  // Show the present step: what moves is at rest in the first and the last fifth.
  show() {
    const { shows, moves, through, twin, seconds } = this.now;
    const part = Math.min(1, Math.max(0, (this.passed / seconds - 0.2) / 0.6));
    const between = (name, from, to) => (isAngle(name) || from * to <= 0 ? from + (to - from) * part : from * (to / from) ** part);
    const moved = Object.entries(moves).map(([name, [from, to]]) => [name, between(name, from, to)]);
    const values = { ...KNIGHT, ...START[shows.scene], ...shows, ...pick(state, ...LOOKER), ...Object.fromEntries(moved) };
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
        const { ended } = this;
        if (!view.behind) this.passed += Math.min(0.5, Math.max(0, (time - last) / 1000));
        if (this.ended !== ended) this.draw();
        if (!this.ended) this.show();
        else if (!this.byHand && !this.isLast) this.next();
      }
      this.run(time);
    });
  },

  isStill() {
    return this.step >= 0 && (this.paused || this.passed > 0.8 * this.now.seconds);
  },

  // What a screen reader speaks of this step.
  says: () => [say("tour.begun"), tour.text(), ...(tour.paused ? [tour.place(reducedMotion.matches ? "count" : "paused")] : [])],
  place: (sentence) => say(`tour.${sentence}`, { n: tour.step + 1, count: tour.steps.length }),
  text() {
    const { intro, steps } = entry(`tours.${TOURS[tour.which].name}`);
    return tour.intro ? intro : steps[tour.step];
  },

  seconds: () => tour.steps.reduce((sum, { seconds }) => sum + seconds, 0),

  // Go back to what the page showed before; or stay, where someone has taken over. The view of the light is `kept` too, if it is this
  // that they use.
  leave(stay = false, kept = false) {
    if (this.step < 0) return;
    this.step = -1;
    inTab("tour", "");
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
    $("tour-count").textContent = this.intro ? "" : this.place("count");
    $("tour-pause").textContent = say(this.paused || this.waits ? "tour.go_on" : "page.pause");
    $("tour-pause").hidden = reducedMotion.matches;
    const over = this.isLast && this.ended;
    if (over && document.activeElement === $("tour-pause")) $("tour-next").focus();
    $("tour-pause").disabled = over;
    $("tour-back").disabled = this.intro || this.step === 0;
    $("tour-next").textContent = say(this.isLast ? "tour.done" : "asking.next");
  },
};

function begin(which) {
  tour.start(true, which);
  tour.draw();
  $("tour-next").focus();  // the button is gone
}
$("tour-start").addEventListener("click", () => begin(0));
for (const button of document.querySelectorAll("[name=tour]")) button.addEventListener("click", () => {
  $("share-open").click();  // its sheet closes
  begin(Number(button.value));
});
$("tour-next").addEventListener("click", () => {
  tour.byHand = true;
  if (tour.isLast) {  // a second click would start the movie whose button is then in this place
    $("presets").inert = true;
    setTimeout(() => ($("presets").inert = false), 700);
  }
  tour.next();
});
$("tour-back").addEventListener("click", () => {
  tour.byHand = true;
  tour.go(tour.step - 1);
});
on("tour-pause", "click", () => {
  tour.paused = !tour.paused && !tour.waits;
  tour.byHand = tour.byHand && tour.paused;
  if (!tour.paused) $("spoken").textContent = say("tour.goes_on");
});
$("tour-leave").addEventListener("click", () => tour.leave());

// Whoever moves something else takes over. A panel, also the teacher's, begins with what the page showed before, and so do the tools if
// nobody asked for the guided start. A language moves nothing.
const taken = ({ target }) => {
  if (tour.step >= 0 && (target.closest?.("#space [data-moves]") || !target.closest?.("#tour, #tour-start, #space-turn, #cameras, #language, footer details"))) tour.leave(!target.closest?.(`[role=tab], #teach-open${tour.asked ? "" : ", #share-open"}`), Boolean(target.closest?.("#space-box")));
};
for (const event of ["input", "change"]) document.addEventListener(event, taken, true);
// What is pressed is where it was until it is released: without the guided start, parts of the page have other places.
for (const [event, parts] of [["pointerdown", "#stage, #space [data-moves], [type=range]"], ["click", "#stage, button, input, select"]]) {
  document.addEventListener(event, (what) => what.target.closest?.(parts) && !isTouch(what) && taken(what), true);
}
// A finger on the picture, or on a slider, may only scroll the page: it takes over when it moves what is there.
/** @param {any} event */
const isTouch = ({ pointerType, target }) => pointerType === "touch" && target.closest("#stage, [type=range]");
let finger = null;
const DRAG = 30;  // pixels: a browser that scrolls has said so before
for (const event of ["pointerdown", "pointerup", "pointercancel"]) {
  document.addEventListener(event, (what) => (finger = event === "pointerdown" && isTouch(what) ? what : null), true);
}
document.addEventListener("pointermove", ({ clientX, clientY }) => {
  if (!finger || Math.hypot(clientX - finger.clientX, clientY - finger.clientY) < DRAG) return;
  taken(finger);
  finger = null;
}, true);
document.addEventListener("keydown", (event) => {
  if (tour.step < 0) return;
  // a presenter's remote control; and the arrows, which lead through the lesson there
  const isOn = document.body.classList.contains("present") && event.target.matches("body, button");
  const way = event.altKey || event.ctrlKey || event.metaKey ? "" : { PageUp: "back", PageDown: "next", ...(isOn ? { ArrowLeft: "back", ArrowRight: "next" } : {}) }[event.key];
  if (way) {
    event.preventDefault();
    $(`tour-${way}`).click();
  } else if (event.key === "Escape") tour.leave();
  else if (event.key === "Tab" && !tour.asked) {  // it has begun by itself: it waits, and its buttons come first
    event.preventDefault();
    Object.assign(tour, { asked: true, paused: true });
    tour.draw();
    $("tour-pause").focus();
  } else if (shortcut(event)) tour.leave(true);
  else if (/^(Arrow|Home|End)/.test(event.key)) taken(event);
}, true);
