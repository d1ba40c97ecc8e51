// What a lesson takes away: a link with its QR code, a frame for another page, a recorded movement, a printed page.

import { toHash } from "./address.js";
import { askAnew, rewriteQuestion } from "./asking.js";
import { $, element, refresh } from "./data.js";
import { clear, isEmpty, keep, key, storage, take, work } from "./kept.js";
import { say } from "./language.js";
import { drawRows } from "./measure.js";
import { drawOther, savedAs, view } from "./picture.js";
import { qr } from "./qr.js";
import { isAsked, QUESTIONS } from "./questions.js";
import { svg } from "./shapes.js";
import { state } from "./state.js";

export const page = () => location.href.replace(/#.*/, "");  // the page's address
// Where a teacher's own question is open, the link opens the first one.
const link = () => page() + toHash().replace(/(#|&)question=own-[^&]*/, `$1question=${QUESTIONS.find(({ own }) => own)?.name}`);

// Put a text on the clipboard. Where the browser does not allow it, the text is shown, and chosen.
async function copy(text) {
  const field = $("link-text");
  try {
    await navigator.clipboard.writeText(text);
    field.hidden = true;
    $("copied").textContent = [say("share.copied"), ...(location.host ? [] : [say("share.only_here")])].join(" ");
  } catch {
    Object.assign(field, { value: text, hidden: false }).select();
    $("copied").textContent = say("share.not_copied");
  }
}

$("copy-link").addEventListener("click", () => copy(link()));
$("copy-embed").addEventListener("click", () => {
  const hidden = [...document.querySelectorAll("[name=hide]:checked")].map(({ value }) => value);
  const address = link().replace(/(\?[^#]*)?(#|$)/, `?embed${hidden.length ? `&hide=${hidden.join(",")}` : ""}$2`);
  copy(element("iframe", { src: address, width: 800, height: 640, title: say("page.title"), allow: "fullscreen" }).outerHTML);
});

// A QR code leads somewhere only if the page has an address that others can open. Return whether there is one.
export function drawCode(drawing) {
  const dark = location.host ? qr(link()) : null;
  if (!dark) return false;
  const side = dark.length + 8;
  const d = dark.flatMap((row, y) => row.flatMap((on, x) => (on ? `M${x + 4} ${y + 4}h1v1h-1z` : []))).join("");
  drawing.setAttribute("viewBox", `0 0 ${side} ${side}`);
  drawing.replaceChildren(svg("rect", { width: side, height: side, fill: "#fff" }), svg("path", { d, fill: "#000" }));
  return true;
}
function offerCode() {
  const drawn = drawCode($("qr").firstElementChild);
  $("qr-open").hidden = !drawn;
  if (location.host && !drawn) $("copied").textContent = say("share.too_long");
  return drawn;
}
// The page may have changed since its tools were opened.
$("qr").addEventListener("beforetoggle", (event) => event.newState === "open" && !offerCode() && event.preventDefault());

for (const id of ["share", "room"]) {
  const button = $(`${id}-open`);
  const open = (shown) => {
    $(id).hidden = !shown;
    button.setAttribute("aria-expanded", String(shown));
    $("copied").textContent = "";
    if (shown) offerCode();
    if (shown && id === "room") scrollTo(0, document.querySelector("main").offsetTop);  // on a phone, the picture stays in sight
    if (!shown && id === "share" && !$("room").hidden) $("room-open").click();  // it belongs to these tools
  };
  button.addEventListener("click", () => open($(id).hidden));
  for (const part of [button, $(id)]) part.addEventListener("keydown", ({ key }) => {
    if (key !== "Escape" || $(id).hidden || document.querySelector(":popover-open")) return;  // the browser closes this alone
    open(false);
    button.focus();
  });
}

// ---- What the browser keeps ----

export function drawKept() {
  for (const part of document.querySelectorAll(".kept")) {
    part.toggleAttribute("hidden", isEmpty());
    part.firstElementChild.textContent = say(`kept.${storage.refused ? "refused" : "kept"}`);
    part.querySelector(".student").value = work.student;
  }
}
for (const field of document.querySelectorAll(".student")) {
  field.addEventListener("input", () => {
    work.student = field.value;
    keep();
    refresh();
  });
  field.addEventListener("keydown", (event) => event.key === "Enter" && event.preventDefault());  // it would reveal an answer
}

// Show other work: it was deleted, or another window of the browser has changed it.
function showOther(change) {
  const before = isAsked();
  change();
  if (isAsked() && !before) askAnew(state.question);
  rewriteQuestion();
  drawRows();
  refresh();
}

$("delete-work").addEventListener("click", ({ target }) => {
  if (target.tagName !== "BUTTON") return;
  $("delete-work").hidePopover();
  if (target.id !== "delete-all") return;
  showOther(clear);
  $("skip").click();  // the button Delete is gone
});
addEventListener("storage", (event) => event.key === key() && showOther(take));
addEventListener("beforeunload", (event) => storage.refused && !isEmpty() && event.preventDefault());

// ---- A recorded movement: of the picture, without what is drawn on it ----

/** @type {MediaRecorder | null} */
let recorder = null;

$("record").hidden = typeof MediaRecorder === "undefined";
$("record").addEventListener("click", () => {
  if (recorder) return recorder.stop();
  const parts = [];
  recorder = new MediaRecorder(view.canvas.captureStream(30), { videoBitsPerSecond: 8e6 });
  recorder.addEventListener("dataavailable", ({ data }) => parts.push(data));
  recorder.addEventListener("stop", () => {
    const type = recorder.mimeType;
    recorder = null;
    showRecording();
    savedAs(URL.createObjectURL(new Blob(parts, { type })), type.includes("mp4") ? "mp4" : "webm");
  });
  recorder.start();
  showRecording();
});

function showRecording() {
  $("record").setAttribute("aria-pressed", Boolean(recorder));
  $("record").dataset.say = recorder ? "share.recording" : "share.record";
  $("record").textContent = say($("record").dataset.say);
}

// ---- Print: a browser prints no WebGL, but a picture ----

const printed = $("print-picture");
addEventListener("beforeprint", () => {
  if (!view.gl || view.gl.isContextLost()) return;
  const { canvas } = view, { width, height } = canvas, copy = element("canvas", { width, height }), pen = copy.getContext("2d");
  view.context.repaint();
  pen.drawImage(canvas, 0, 0);
  drawOther(pen, copy);
  printed.src = copy.toDataURL("image/png");
});
addEventListener("afterprint", () => printed.removeAttribute("src"));
// Print when the pictures are there. `prepare` writes what is printed with them.
export async function printPicture(prepare = async () => {}) {
  dispatchEvent(new Event("beforeprint"));
  await prepare();
  await Promise.allSettled([printed, $("rooms-printed"), ...document.querySelectorAll("#tasks img")].map((image) => image.decode()));
  print();
}
$("print").addEventListener("click", () => printPicture());
