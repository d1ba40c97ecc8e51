// The page that shows the live view alone. In Jupyter it exchanges values with Python, by way of liveview/widget.js.

import { onArrows, onDrag } from "./pointer.js";
import { benchText } from "./readout.js";
import { LiveView } from "./view.js";

const data = JSON.parse(document.getElementById("data").textContent);
const message = document.getElementById("message");
export const view = new LiveView(document.getElementById("view"), data.scene, data.volumes, (why, reason) => {
  message.textContent = why ? data.failures[why].replace("{reason}", reason) : "";
});
const held = movable(view, document.getElementById("area"), (povgen) => {
  if (window.parent !== window) window.parent.postMessage({ povgen }, "*");
});
window.addEventListener("message", ({ source, data }) => {
  if (source !== window.parent || !data?.povgen) return;
  const { eye, alpha } = view.scene, { back, ...values } = data.povgen;
  // The answer to a movement comes while it goes on. If the scene does not allow the movement, the view goes back.
  view.set(held() && !back ? { ...values, eye, alpha } : values);
});
if (new URLSearchParams(location.search).has("bench")) {
  view.ready.then(() => view.gl && (message.textContent = benchText(view)));
}

// ---- Moving the eye; with Shift, changing alpha. By dragging and the arrow keys ----

const STEP = 0.05;     // tiles, for a press of a key
const DEGREES = 0.25;  // for a pixel; for a press of a key four times as much
const FARTHEST = 10;   // the eye from the window's centre, tiles

// Call `moved` with what a user changes of the view's scene: { eye } or { alpha }. Return a function: whether a pointer
// holds the view.
function movable(view, area, moved) {
  const change = (values) => {
    view.set(values);
    moved(values);
  };
  const from = (scene, [x, y], alpha) =>
    alpha === undefined
      ? { eye: [scene.eye[0] + x, scene.eye[1] + y].map((place) => Math.max(-FARTHEST, Math.min(FARTHEST, place))) }
      : { alpha: ((((scene.alpha + alpha + 180) % 360) + 360) % 360) - 180 };

  onArrows(area, ([x, y], { shiftKey }) => change(from(view.scene, [STEP * x, STEP * y], shiftKey ? 4 * DEGREES * (x + y) : undefined)));
  return onDrag(area, () => {
    const scene = { ...view.scene };
    return ([right, up], { shiftKey }) => {
      const tiles = view.scene.view / area.clientHeight;
      change(from(scene, [tiles * right, tiles * up], shiftKey ? DEGREES * right : undefined));
    };
  });
}
