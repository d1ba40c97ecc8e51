// Show the state everywhere: in the picture, the diagram, the numbers, the address, and in words.

import { benchText } from "../live/readout.js";
import { fromHash, toHash } from "./address.js";
import { drawQuestion, endGlide } from "./asking.js";
import { drawTabs, showInputs, showMarks, showNumbers } from "./controls.js";
import { $ } from "./data.js";
import { drawDiagram } from "./diagram.js";
import { drawBy, refresh } from "./frame.js";
import { placeHandles } from "./handles.js";
import { moment } from "./moment.js";
import { drawOverlay, stage } from "./overlay.js";
import { view } from "./picture.js";
import { player, povray } from "./player.js";
import { drawSketch, sketch } from "./sketch.js";
import { session, state } from "./state.js";
import { describe } from "./text.js";

export function draw() {
  const now = moment();
  view.set(now.scene);
  drawTabs();
  drawQuestion();
  showInputs(now);
  showNumbers(now);  // before the drawings: the length of the text decides how large they are
  drawOverlay(now);
  drawDiagram(now);
  drawSketch(now);
  placeHandles(now);
  showMarks();
  player.draw();
  povray.draw();
  later("speak", 900, () => speak(now));
  later("address", 400, keepAddress);
}

// Do something when the page has been still for some time, milliseconds.
const timers = {};
function later(name, time, action) {
  clearTimeout(timers[name]);
  if (!player.playing) timers[name] = setTimeout(action, time);
}

let silent = true;  // until something has changed
function speak(now) {
  const text = describe(now);
  $("view").setAttribute("aria-label", text);
  if (!silent && $("spoken").textContent !== text) $("spoken").textContent = text;
  silent = false;
}

// Whether something is being dragged, such as a slider: the address follows when it is released.
let pressed = false;
for (const event of ["pointerdown", "pointermove", "pointerup", "pointercancel"]) {
  addEventListener(event, ({ buttons }) => (pressed = Boolean(buttons & 1)), true);
}

export function keepAddress() {
  if (pressed) return later("address", 400, keepAddress);
  if (toHash() === kept) return;
  kept = toHash();
  location.hash = kept;  // in Jupyter's frames history.pushState is forbidden
}

addEventListener("popstate", () => {
  if (location.hash === kept) return;
  player.pause();
  endGlide();
  session.typing = null;
  if (state.question < 0) session.explored = { ...state };
  fromHash(location.hash);
  kept = toHash();
  refresh();
});

drawBy(draw);
fromHash(location.hash);
let kept = toHash();  // the state that the address has
for (const part of [stage, $("diagram-box"), sketch]) new ResizeObserver(refresh).observe(part);
document.fonts?.ready.then(refresh);
view.ready.then(() => {
  $("hint").textContent = "Drag the object, or drag beside it to move your eye";
  refresh();
});
refresh();
if (new URLSearchParams(location.search).has("bench")) view.ready.then(() => ($("message").textContent = benchText(view)));
