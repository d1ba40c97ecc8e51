// The page that shows the live view alone.

import { benchText } from "./readout.js";
import { LiveView } from "./view.js";

const data = JSON.parse(document.getElementById("data").textContent);
const message = document.getElementById("message");
export const view = new LiveView(document.getElementById("view"), data.scene, data.volumes, (sentence) => {
  message.textContent = sentence ?? "";
});
if (new URLSearchParams(location.search).has("bench")) {
  view.ready.then(() => (message.textContent = benchText(view)));
}
