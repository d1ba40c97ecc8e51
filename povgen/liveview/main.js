// The page that shows the live view alone. In Jupyter it exchanges values with Python, by way of liveview/widget.js.

import { movable } from "./moving.js";
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
