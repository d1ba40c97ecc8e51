// The canvas, its picture as a file, what is shown where there is none, and the curtain with a second picture.

import { still } from "../liveview/readout.js";
import { LiveView } from "../liveview/view.js";
import { toHash } from "./address.js";
import { openQuestion } from "./asking.js";
import { $, data, element, on, refresh } from "./data.js";
import { percent, say } from "./language.js";
import { moment, otherScene, sceneValues } from "./moment.js";
import { outlinesOf } from "./outline.js";
import { drawOverlay, overlay } from "./overlay.js";
import { ofKind } from "./phrases.js";
import { player } from "./player.js";
import { svg } from "./shapes.js";
import { CAMERAS, change, OPENING, replace, session, state } from "./state.js";

let failure = ["", ""];  // why there is no picture, and what the browser says

function failed(why, reason = "") {
  failure = [why, reason];
  writeFailure();
  document.body.classList.toggle("failed", Boolean(why));
  refresh();
}

export function writeFailure() {
  const [why, reason] = failure, hasMovies = data.presets.some(({ movie }) => movie);
  const sentences = why ? [say(`failures.${why}`, { reason }), ...(hasMovies ? [say("failures.movies")] : [])] : [];
  $("message").textContent = sentences.join(" ");
}

export const view = new LiveView($("view"), { ...sceneValues(), pictures: data.scenes.chess.pictures }, data.volumes, failed);
outlinesOf(view.shapes);
view.loading.then(refresh, () => {});

// The poster shows what the page opens with, until it is drawn.
const unveil = () => (view.behind ? requestAnimationFrame(unveil) : $("poster")?.remove());
view.ready.then(unveil);

// Draw what the page shows. The guided start opens with the piece a second time, beside the window.
export function drawView({ scene }) {
  const { piece, x, z1 } = scene;
  view.set(session.twin ? { ...scene, piece: [piece, piece], x: [x, session.twin], z1: [z1, z1] } : scene);
}

// Save the picture with its overlay and its numbers, at least 1920 pixels wide.
async function savePicture() {
  await drawable();
  const width = Math.max(1920, view.canvas.width);
  const canvas = still(view, width, Math.round((width * view.canvas.height) / view.canvas.width));
  const pen = canvas.getContext("2d");
  drawOther(pen, canvas);
  pen.drawImage(await overlayImage(canvas), 0, 0);
  savedAs(canvas.toDataURL("image/png"), "png");
}

// Return when the views have drawn. A view does not draw while it is out of sight. Without a curtain the other view is hidden.
async function drawable() {
  if (!view.inSight) $("stage").scrollIntoView();
  await view.ready;
  const drawn = (each) => each.gl && !each.lost && !each.stale && each.context.shown;
  while (!drawn(view) || (state.compare !== "off" && otherView() && !drawn(otherView()))) await new Promise(requestAnimationFrame);
}

// Save what an address holds as a file, whose name has the numbers.
export function savedAs(href, ending) {
  const numbers = toHash().slice(1).replace(/&?(show|diagram|question|own|light|level|language)=[^&]*/g, "").replaceAll("&", " ");
  element("a", { href, download: `povgen ${numbers}.${ending}` }).click();
}

// The overlay, by default with its caption, as an image of the canvas's size.
export async function overlayImage({ width, height }, caption = true) {
  const before = state.caption;
  state.caption = caption;
  drawOverlay(moment());
  state.caption = before;
  const copy = overlay.cloneNode(true);
  refresh();
  copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  copy.setAttribute("width", width);
  copy.setAttribute("height", height);
  copy.append(svg("style", {}, $("overlay-style").textContent));
  const image = new Image();
  image.src = `data:image/svg+xml,${encodeURIComponent(new XMLSerializer().serializeToString(copy))}`;
  await image.decode();
  return image;
}

$("save").addEventListener("click", savePicture);
$("full-screen").addEventListener("click", () => (document.fullscreenElement ? document.exitFullscreen() : document.documentElement.requestFullscreen()));
$("full-screen").hidden = !document.fullscreenEnabled;
document.addEventListener("fullscreenchange", () => $("full-screen").setAttribute("aria-pressed", Boolean(document.fullscreenElement)));
on("reset", "click", () => {
  openQuestion(-1);  // Undo brings back what has been explored
  player.pause();
  [session.explored, session.own, session.lastQuestion] = [null, {}, 0];  // the page's questions, also where the address has a teacher's own
  replace(OPENING);
  [session.camera, session.zoom] = [CAMERAS.corner, 1];
  player.reset();
});

// ---- Two settings side by side ----

// To the right of a curtain across the picture, the window has other sheets. A second live view draws them. It is made when it is
// first wanted.

/** @type {LiveView | null} */
let other = null;
let sky = null;  // the picture in the place of the mountains
export const otherView = () => other;

export function drawCompare(now) {
  const shown = state.compare !== "off";
  for (const id of ["curtain", "curtain-line", "other-view", "curtain-names"]) $(id).hidden = !shown;
  $("compare").value = state.compare;
  if (!shown) return;
  const scene = otherScene(now);
  if (!other) {
    other = new LiveView($("other-view"), { ...scene, pictures: data.scenes.chess.pictures }, data.volumes);
    other.ready.then(() => sky && other.setSky(sky));
  } else other.set(scene);
  $("stage").style.setProperty("--curtain", session.curtain);
  $("curtain").value = 100 * session.curtain;
  const left = ofKind(now.sheet, "choice", data.kinds[now.sheet]), right = ofKind(state.compare, "choice");
  $("name-left").textContent = left;
  $("name-right").textContent = right;
  $("curtain").setAttribute("aria-valuetext", say("compare.shares", { left, right, part: percent(session.curtain), rest: percent(1 - session.curtain) }));
}

// Show a picture in the place of the mountains, as LiveView.setSky does.
export function setOtherSky(picture) {
  sky = picture;
  other?.setSky(picture);
}

// Draw what is to the right of the curtain, for a picture's file. `anew`: without glasses, and as fine as the file.
export function drawOther(pen, { width, height }, anew = false) {
  if (state.compare === "off" || !other?.gl) return;
  if (anew) other.set({ eyes: 0 });
  else other.context.repaint();
  const left = Math.round(session.curtain * width), canvas = anew ? still(other, width, height) : other.canvas;
  pen.drawImage(canvas, session.curtain * canvas.width, 0, (1 - session.curtain) * canvas.width, canvas.height, left, 0, width - left, height);
}

on("compare", "change", () => change({ compare: $("compare").value }));
on("curtain", "input", () => (session.curtain = $("curtain").value / 100));
