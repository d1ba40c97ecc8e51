// How the page looks: dark or light, for a projector, or as a frame in another page.

import { $, refresh } from "./data.js";
import { inTab } from "./kept.js";

const root = document.documentElement, dark = matchMedia("(prefers-color-scheme: dark)");

function look(isDark) {
  root.dataset.look = isDark ? "dark" : "light";
  $("dark").setAttribute("aria-pressed", isDark);
  refresh();
}
look(dark.matches);
dark.addEventListener("change", () => look(dark.matches));
$("dark").addEventListener("click", () => look(root.dataset.look !== "dark"));

// For a projector: the picture, the sentence, the sheets and one slider, in large type, and a pointer.
export function present(on) {
  const focused = document.activeElement === $("leave");
  document.body.classList.toggle("present", on);
  $("leave").hidden = $("lesson").hidden = !on;
  inTab("present", on ? "on" : "");
  if (focused && !on) $("share-open").focus();  // the button is gone
  $("pointer").hidden = true;  // until it moves
  refresh();
}
$("present").addEventListener("click", () => {
  $("share-open").click();  // closes the tools
  present(true);
  $("lesson-next").focus();  // not Leave: a space would end it
});
$("leave").addEventListener("click", () => present(false));
if (inTab("present")) present(true);  // it was loaded again
document.addEventListener("keydown", ({ key }) => {
  if (key === "Escape" && document.body.classList.contains("present") && !document.querySelector(":popover-open")) present(false);
});
let resting = 0;
$("stage-box").addEventListener("pointermove", ({ clientX, clientY }) => {
  $("pointer").style.transform = `translate(${clientX}px, ${clientY}px)`;
  $("pointer").hidden = false;
  clearTimeout(resting);
  resting = setTimeout(() => ($("pointer").hidden = true), 3000);  // a mouse that rests covers nothing
});

// ?embed: a frame in another page. ?hide=header,panel,said,player: what it leaves out.
const asked = new URLSearchParams(location.search);
document.body.classList.toggle("embed", asked.has("embed"));
for (const part of (asked.get("hide") ?? "").split(",")) if (/^(header|panel|said|player)$/.test(part)) document.body.classList.add(`hide-${part}`);
