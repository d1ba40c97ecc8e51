// Show the state everywhere: in the picture, the diagram, the numbers, the address, and in words.

import { fromHash, toHash } from "./address.js";
import { drawQuestion, endGlide, rewriteQuestion } from "./asking.js";
import { drawTabs, fillPage, showInputs, showMarks, showNumbers } from "./controls.js";
import { $, drawBy, pick, refresh } from "./data.js";
import { drawDiagram } from "./diagram.js";
import { placeHandles } from "./handles.js";
import { drawKept, page } from "./handouts.js";
import { chooseUsual, say, SETTINGS, spoken } from "./language.js";
import "./headset.js";
import { inTab, isReloaded } from "./kept.js";
import "./look.js";
import { drawMeasure, drawRows, pointsAsked } from "./measure.js";
import { moment } from "./moment.js";
import { drawOverlay, stage } from "./overlay.js";
import { drawCompare, drawView, view, writeFailure } from "./picture.js";
import { player, povray } from "./player.js";
import { QUESTIONS } from "./questions.js";
import { drawBehind } from "./room.js";
import { drawRoom } from "./rooms.js";
import { tell } from "./sound.js";
import { drawSpace } from "./space.js";
import { session, state } from "./state.js";
import { drawPlace, locate } from "./teaching.js";
import { describe, explanation, heard, isToBeFound, seen } from "./text.js";
import "./tilt.js";
import { tour } from "./tour.js";

let written = "";  // the language of the page's sentences

function rewrite() {
  written = spoken.language;
  fillPage();
  writeFailure();
  rewriteQuestion();
  drawRows();
  for (const id of ["spoken", "own-message", "copied", "room-message", "rooms-eye"]) $(id).textContent = "";
}

function drawPage() {
  if (written !== spoken.language) rewrite();
  drawBehind();  // before moment(): it says whether there is a floor
  const now = moment();
  drawView(now);
  drawTabs();
  drawQuestion();
  drawPlace();
  player.follow();
  showInputs(now);
  showNumbers(now);  // before the drawings: the length of the text decides how large they are
  drawOverlay(now);
  drawDiagram(now);
  drawSpace(now);
  drawCompare(now);
  drawMeasure(now);
  drawKept();
  placeHandles(now);
  showMarks();
  tell(now);
  player.draw(now);
  tour.draw();
  povray.draw();
  drawRoom();
  if (tour.step >= 0) speak(now);
  later("speak", 900, () => speak(now));
  later("address", 400, keepAddress);
}

// Do something when the page has been still for some time, milliseconds.
const timers = {};
function later(name, time, action) {
  const still = () => !player.playing && tour.step < 0;
  clearTimeout(timers[name]);
  if (still()) timers[name] = setTimeout(() => still() && action(), time);  // a movement may begin before it is drawn
}

let silent = true;  // until something has changed since the page was opened
let told = [];   // what has been spoken last
let toldOf = "";  // the settings that it was spoken of
function speak(now) {
  const touring = tour.step >= 0;
  if (!touring || tour.isStill()) $("view").setAttribute("aria-label", describe(now));
  silent &&= toHash() === opened && !touring;
  // the guided start waits for who goes from step to step: only then is there time to say what is seen, too
  const sentences = !touring ? [...heard(now), ...pointsAsked()] : [...tour.says(), ...(tour.paused && state.light !== "prism" ? [seen(now)] : [])];
  const news = sentences.filter((sentence) => sentence && !told.includes(sentence)), set = JSON.stringify(pick(state, ...SETTINGS));
  // other settings can look the same, as 180 and -180 degrees do: then what is seen is spoken again, as a new text
  if (!news.length && set !== toldOf && !touring && !isToBeFound()) news.push(`${explanation(now)}${$("spoken").textContent.endsWith("\u00a0") ? "" : "\u00a0"}`);
  if (!silent && news.length) $("spoken").textContent = news.join(" ");
  [told, toldOf] = [sentences, set];
}

// Whether something is being dragged, such as a slider: the address follows when it is released.
let pressed = false;
for (const event of ["pointerdown", "pointermove", "pointerup", "pointercancel"]) {
  addEventListener(event, ({ buttons }) => (pressed = Boolean(buttons & 1)), true);
}

// The browser's Back leads to what was shown before another one of these was chosen. All other changes, such as those of a slider, are
// kept in the present entry of the browser's history.
const chosen = () => JSON.stringify({ ...pick(state, "scene", "sheet", "windows", "sheet2", "question", "level", "large"), room: session.room });

export function keepAddress() {
  if (pressed) return later("address", 400, keepAddress);
  if (toHash() === kept) return;
  const isNew = chosen() !== keptChoice;
  [kept, keptChoice] = [toHash(), chosen()];
  const address = page() + kept;
  if (isNew) location.hash = kept;
  else {
    try {
      history.replaceState(null, "", address);
    } catch {  // it is forbidden in Jupyter's frames
      location.replace(address);
    }
  }
}

addEventListener("popstate", () => {
  if (location.hash === kept) return;
  player.pause();
  tour.leave();
  endGlide();
  session.typing = null;
  if (state.question < 0) session.explored = { ...state };
  chooseUsual();  // unless the address has another
  fromHash(location.hash);
  locate(location.hash);
  [kept, keptChoice] = [toHash(), chosen()];
  refresh();
});

drawBy(drawPage);
if (isReloaded) session.lastQuestion = QUESTIONS.findIndex(({ name }) => name === inTab("question"));
fromHash(location.hash);
const opened = toHash();
let kept = opened, keptChoice = chosen();  // the state that the address has
for (const part of [stage, $("diagram-box"), $("space-turn"), $("rooms-area")]) new ResizeObserver(refresh).observe(part);
document.fonts?.ready.then(refresh);
view.ready.then(() => {
  $("hint").textContent = say($("hint").dataset.say = "page.hint");
  refresh();
  if (!view.gl) tour.leave();
});
const left = isReloaded && inTab("tour");
if (left) tour.start(...JSON.parse(left));
else if (document.body.classList.contains("begins")) tour.start();
refresh();
