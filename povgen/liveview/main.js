// The page that shows the live view alone. In Jupyter it exchanges values with Python, by way of liveview/widget.js.

import { onArrows, onDrag } from "./pointer.js";
import { camera, steppedEye } from "./presets.js";
import { LiveView } from "./view.js";

const data = JSON.parse(document.getElementById("data").textContent);
const message = document.getElementById("message");
export const view = new LiveView(document.getElementById("view"), data.scene, data.volumes, (why, reason) => {
  message.textContent = why ? data.failures[why].replace("{reason}", reason) : "";
});
const tell = (povgen) => window.parent !== window && window.parent.postMessage({ povgen }, "*");
const held = movable(view, document.getElementById("area"), tell);
window.addEventListener("message", ({ source, data }) => {
  if (source !== window.parent || !data?.povgen) return;
  const { eye, alpha, windows } = view.scene, { back, ...values } = data.povgen;
  // The answer to a movement comes while it goes on. If the scene does not allow the movement, the view goes back.
  const holds = (held() || document.querySelector("input:active")) && !back;
  view.set(holds ? { ...values, eye, alpha, windows } : values);
  if (!holds) makeSliders();
});
makeSliders();

// ---- Moving the eye, and changing alpha ----

const STEP = 0.05;     // tiles, for a press of a key
const DEGREES = 0.25;  // for a pixel; for a press of a key four times as much
const FARTHEST = 10;   // a preset's eye from the window's centre, tiles

function within(angle) {
  return ((((angle + 180) % 360) + 360) % 360) - 180;
}

// The scene's eye after a step to the right and up.
function movedEye(scene, [x, y]) {
  if (scene.objects) return steppedEye(scene, [x, y]);
  return [scene.eye[0] + x, scene.eye[1] + y].map((place) => Math.max(-FARTHEST, Math.min(FARTHEST, place)));
}

// By dragging and the arrow keys the eye moves; with Shift, alpha of a preset's first window changes. Call `moved` with what a user
// changes of the view's scene: { eye } or { alpha }. Return a function: whether a pointer holds the view.
function movable(view, area, moved) {
  const change = (values) => {
    view.set(values);
    moved(values);
  };
  const from = (scene, step, alpha) =>
    alpha === undefined || scene.objects ? { eye: movedEye(scene, step) } : { alpha: within(scene.alpha + alpha) };

  onArrows(area, ([x, y], { shiftKey }) => change(from(view.scene, [STEP * x, STEP * y], shiftKey ? 4 * DEGREES * (x + y) : undefined)));
  return onDrag(area, () => {
    const scene = { ...view.scene };
    return ([right, up], { shiftKey }) => {
      const tiles = camera(scene).height / area.clientHeight;
      change(from(scene, [tiles * right, tiles * up], shiftKey ? DEGREES * right : undefined));
    };
  });
}

// A slider for alpha of each window of a room that has one.
function makeSliders() {
  const { windows = [] } = view.scene;
  document.getElementById("sliders").replaceChildren(...windows.flatMap(({ name, values }, number) => ("alpha" in values ? [slider(name, values.alpha, (alpha) => {
    const turned = view.scene.windows.map((each, k) => (k === number ? { ...each, values: { ...each.values, alpha } } : each));
    view.set({ windows: turned });
    tell({ alphas: turned.map((each) => each.values.alpha ?? null) });
  })] : [])));
}

// A slider for an angle in degrees, with its name and its value.
function slider(name, angle, changed) {
  const label = document.createElement("label"), value = document.createElement("span");
  const input = Object.assign(document.createElement("input"), { type: "range", min: -180, max: 180, step: "any", value: within(angle) });
  const write = (alpha) => (value.textContent = ` \u03b1 = ${Number(alpha.toFixed(3))}\u00b0`);
  input.addEventListener("input", () => {
    const alpha = Math.round(10 * input.value) / 10;
    write(alpha);
    changed(alpha);
  });
  write(angle);
  label.append(name, input, value);
  return label;
}
