// A question of a teacher's own, in a link.

import { fromHash, toHash } from "./address.js";
import { openQuestion } from "./asking.js";
import { $ } from "./data.js";
import { refresh } from "./frame.js";
import { say } from "./language.js";
import { MOST_CHOICES } from "./questions.js";
import { session } from "./state.js";

const kept = { before: "", after: "" };  // the addresses of what the page shows first, and with the answer
const shown = () => toHash().replace(/&(question|own|language)=[^&]*/g, "");

for (const [id, part] of Object.entries({ start: "before", end: "after" })) {
  $(`own-${id}`).addEventListener("click", () => {
    kept[part] = shown();
    $(`own-${id}`).setAttribute("aria-pressed", true);
  });
}

$("own").addEventListener("submit", (event) => {
  event.preventDefault();
  const lines = (id) => $(id).value.split("\n").map((line) => line.trim()).filter(Boolean);
  const [ask, choices, why] = [lines("own-text").join(" "), lines("own-choices"), lines("own-why").join(" ")];
  const complete = ask && choices.length > 1 && choices.length <= MOST_CHOICES;
  $("own-message").textContent = complete ? "" : say("asking.own_missing", { most: MOST_CHOICES });
  if (!complete) return $("own-text").focus();
  const question = { ask, choices, why, before: kept.before || shown(), after: kept.after || shown() };
  openQuestion(-1);
  session.own_question = "";  // the same one is asked anew
  fromHash(`${question.before}&own=${encodeURIComponent(JSON.stringify(question))}`);
  refresh();
  $("ask").focus();
});
