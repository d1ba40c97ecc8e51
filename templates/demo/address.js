// The state in the page's address.

import { chosenBeyond } from "./beyond.js";
import { data } from "./data.js";
import { QUESTIONS, revealed } from "./questions.js";
import { change, CHOICES, OPENING, RANGES, session, START, state } from "./state.js";

const short = (x) => String(Number(x.toPrecision(7)));
export const SWITCHES = ["position", "circles", "image", "caption"];

export function toHash() {
  const { scene, sheet, piece, question } = state;
  const parts = { scene, sheet };
  if (scene === "chess") parts.piece = piece;
  for (const name of ["alpha", "z1", "z2", "prisms"]) parts[name] = short(state[name]);
  const own = chosenBeyond() === "series" ? ["windows", "alpha2", "d"] : Object.keys(data.kinds[sheet]?.parameters ?? {});
  for (const name of own) parts[name] = [state[name]].flat().map(short).join(",");
  for (const name of ["L", "E"]) parts[name] = state[name].map(short).join(",");
  parts.show = SWITCHES.filter((name) => state[name]).join(",");
  parts.diagram = state.diagram;
  if (question >= 0) parts.question = question + 1;
  return `#${Object.entries(parts).map(([name, value]) => `${name}=${encodeURIComponent(value).replaceAll("%2C", ",")}`).join("&")}`;
}

// Take the values from an address. What is missing or wrong there has the value that the page opens with. A question whose
// answer has not been revealed is shown as before its answer.
export function fromHash(hash) {
  const given = new URLSearchParams(hash.slice(1));
  const values = {};
  for (const [name, allowed] of Object.entries(CHOICES)) if (allowed.includes(given.get(name))) values[name] = given.get(name);
  for (const name of ["L", "E", ...Object.keys(RANGES)]) {
    const parts = (given.get(name) ?? "").split(",");
    if (parts.length !== [OPENING[name]].flat().length || !parts.every(isNumber)) continue;
    values[name] = Array.isArray(OPENING[name]) ? parts.map(Number) : Number(parts[0]);
  }
  if (given.has("show")) for (const name of SWITCHES) values[name] = given.get("show").split(",").includes(name);
  const question = Number(given.get("question")) - 1;
  if (QUESTIONS[question]) Object.assign(values, { question }, revealed.has(question) ? {} : QUESTIONS[question].before);
  Object.assign(state, OPENING, START[values.scene ?? "chess"]);
  change(values);
  [session.replaced, session.own] = [null, {}];
}
const isNumber = (text) => Boolean(text?.trim()) && Number.isFinite(Number(text));
