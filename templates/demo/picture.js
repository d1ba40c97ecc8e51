// The canvas, its picture as a file, and what is shown where there is none.

import { LiveView } from "../live/view.js";
import { toHash } from "./address.js";
import { replace } from "./beyond.js";
import { $, data } from "./data.js";
import { refresh } from "./frame.js";
import { moment, sceneValues } from "./moment.js";
import { outlinesOf } from "./outline.js";
import { drawOverlay, overlay } from "./overlay.js";
import { player } from "./player.js";
import { svg } from "./shapes.js";
import { OPENING, session, START, state } from "./state.js";

function failed(sentence) {
  $("message").textContent = sentence ? `${sentence}${data.presets.some(({ movie }) => movie) ? " Meanwhile you see POV-Ray’s movies." : ""}` : "";
  document.body.classList.toggle("failed", Boolean(sentence));
  refresh();
}

export const view = new LiveView($("view"), sceneValues(), data.volumes, failed);
view.loading.then(outlinesOf, () => {});

// Save the picture with its overlay and its numbers.
async function savePicture() {
  const canvas = Object.assign(document.createElement("canvas"), { width: view.canvas.width, height: view.canvas.height });
  const pen = canvas.getContext("2d");
  view.context.repaint();
  pen.drawImage(view.canvas, 0, 0);
  pen.drawImage(await overlayImage(canvas), 0, 0);
  const link = document.createElement("a");
  link.href = canvas.toDataURL("image/png");
  link.download = `povgen ${toHash().slice(1).replace(/&?(show|diagram|question)=[^&]*/g, "").replaceAll("&", " ")}.png`;
  link.click();
}

// The overlay with its caption, as an image of the canvas's size.
async function overlayImage({ width, height }) {
  const before = state.caption;
  state.caption = true;
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
$("reset").addEventListener("click", () => {
  player.reset();
  [session.explored, session.own] = [null, {}];
  const { scene } = state;
  replace({ ...OPENING, scene, ...START[scene] });
  refresh();
});
