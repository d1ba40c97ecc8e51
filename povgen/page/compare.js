// Two settings side by side: a curtain across the picture, to the right of which the window has other sheets. A second live view
// draws them. It is made when it is first wanted.

import { LiveView } from "../liveview/view.js";
import { $, data } from "./data.js";
import { on } from "./frame.js";
import { percent, say } from "./language.js";
import { otherScene } from "./moment.js";
import { ofKind } from "./phrases.js";
import { change, session, state } from "./state.js";

/** @type {LiveView | null} */
let other = null;
let sky = null;  // the picture in the place of the mountains
export const otherView = () => other;

export function drawCompare(now) {
  const on = state.compare !== "off";
  for (const id of ["curtain", "curtain-line", "other-view", "curtain-names"]) $(id).hidden = !on;
  $("compare").value = state.compare;
  if (!on) return;
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

// Draw what is to the right of the curtain, for a picture's file.
export function drawOther(pen, { width, height }) {
  if (state.compare === "off" || !other?.gl) return;
  const left = Math.round(session.curtain * width), { canvas } = other;
  other.context.repaint();
  pen.drawImage(canvas, session.curtain * canvas.width, 0, (1 - session.curtain) * canvas.width, canvas.height, left, 0, width - left, height);
}

on("compare", "change", () => change({ compare: $("compare").value }));
on("curtain", "input", () => (session.curtain = $("curtain").value / 100));
