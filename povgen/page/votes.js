// The votes of a class, before and after it has discussed a question: a number for each choice, and bars.

import { $, element } from "./data.js";
import { percent, say } from "./language.js";

const votes = new Map();  // the questions, and for each one or two lists of votes

export function drawVotes(question, choices) {
  if (!choices) return $("votes").replaceChildren();
  const none = () => choices.map(() => 0);
  const rounds = votes.get(question) ?? votes.set(question, [none()]).get(question), given = rounds.at(-1);
  const rows = choices.map((choice, k) => {
    const field = element("input", { type: "number", min: 0, max: 999, value: given[k], className: "field", ariaLabel: say("asking.votes_for", { choice }) });
    field.addEventListener("input", () => {
      given[k] = Math.max(0, Math.round(Number(field.value)) || 0);
      show();
    });
    const bars = rounds.map(() => element("i")), share = element("output", { ariaLive: "off" });  // the field says the number
    return { row: element("label", {}, element("span", {}, choice), field, element("span", { className: "track" }, ...bars), share), bars, share };
  });
  const show = () => rows.forEach(({ bars, share }, k) => {
    const shares = rounds.map((round) => round[k] / round.reduce((sum, x) => sum + x, 0) || 0);
    bars.forEach((bar, m) => (bar.style.width = `${100 * shares[m]}%`));
    share.textContent = rounds.flat().some(Boolean) ? shares.map(percent).join(" → ") : "";
  });
  const again = element("button", { type: "button", textContent: say("asking.vote_again"), hidden: rounds.length > 1 });
  again.addEventListener("click", () => {
    rounds.push(none());
    drawVotes(question, choices);
    $("votes").querySelector("input").focus();
  });
  $("votes").replaceChildren(...rows.map(({ row }) => row), again);
  show();
}
