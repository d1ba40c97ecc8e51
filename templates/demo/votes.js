// The votes of a class: a number for each choice of a question, and bars.

import { $ } from "./data.js";
import { percent, say } from "./language.js";

const votes = new Map();  // the numbers of the questions, and a list of votes for each

export function drawVotes(n, choices) {
  if (!choices) return $("votes").replaceChildren();
  const given = votes.get(n) ?? votes.set(n, choices.map(() => 0)).get(n);
  const bars = [];
  const show = () => {
    const all = given.reduce((sum, x) => sum + x, 0);
    bars.forEach(({ bar, share }, k) => {
      bar.style.width = `${all ? (100 * given[k]) / all : 0}%`;
      share.textContent = all ? percent(given[k] / all) : "";
    });
  };
  $("votes").replaceChildren(...choices.map((choice, k) => {
    const row = document.createElement("label"), track = document.createElement("span");
    const name = Object.assign(document.createElement("span"), { textContent: choice });
    const field = Object.assign(document.createElement("input"), { type: "number", min: 0, max: 999, value: given[k], className: "field" });
    const [bar, share] = [document.createElement("i"), document.createElement("output")];
    field.setAttribute("aria-label", say("asking.votes_for", { choice }));
    field.addEventListener("input", () => {
      given[k] = Math.max(0, Math.round(Number(field.value)) || 0);
      show();
    });
    track.className = "track";
    track.append(bar);
    bars.push({ bar, share });
    row.append(name, field, track, share);
    return row;
  }));
  show();
}
