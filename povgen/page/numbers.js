// Numbers, as the page prints them and as it reads them.

import { radians } from "../liveview/geometry.js";
import { finite } from "./complex.js";
import { data } from "./data.js";
import { entry, localised, say, separator } from "./language.js";

const ofSheets = (what) => Object.fromEntries(Object.entries(data.parameters).map(([name, parameter]) => [name, parameter[what]]));
/** @type {Record<string, string>} */
export const SYMBOL = { ...ofSheets("symbol"), z1: "z₁", z2: "z₂", prisms: "N", alpha2: "α₂", d: "d" };
const UNIT = { ...ofSheets("unit"), z1: "tiles", z2: "tiles", alpha2: "°", d: "tiles" };

// The settings that can be replaced.
export const SETTINGS = [...Object.keys(SYMBOL), "L", "E", "piece", "sheet", "sheet2", "windows"];

const raised = (n) => [...String(n)].map((digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit] ?? "⁻").join("");

// The number that someone has typed, with a decimal point or comma, as a fraction, or with a unit. NaN if it is none.
export function readNumber(text) {
  const plain = text.replaceAll(",", ".").replaceAll("−", "-").replace(new RegExp(`(°|${entry("units.typed").split(" ").join("|")})\\s*$`), "");
  const parts = plain.split("/");
  if (parts.length > 2 || !parts.every((part) => part.trim())) return NaN;
  const [above, below = 1] = parts.map(Number);
  return above / below;
}

// The text of toFixed, toPrecision or toExponential with typographic signs. A number that rounds to 0 has no sign.
export function printed(text) {
  const [digits, power] = text.replace(/^-/, "").split("e");
  const sign = text.startsWith("-") && Number(digits) ? "−" : "";
  return sign + localised(digits) + (power ? ` × 10${raised(Number(power))}` : "");
}

export const fixed = (x, digits) => printed(Math.abs(x) < 1e5 ? x.toFixed(digits) : x.toExponential(2).replace("Infinity", "∞"));
export const size = (x) => (Number.isFinite(x) ? printed(x < 1e4 ? x.toPrecision(4) : x.toExponential(2)) : "∞");
export const brief = (x) => (Number.isFinite(x) ? printed(String(Number(x.toPrecision(3)))) : "∞");
export const rough = (x) => printed(String(Number(x.toPrecision(2))));
export const angle = (x) => (Number.isNaN(x) ? say("numbers.undefined") : `${fixed(x / radians(1), 1)}°`);

export const isAngle = (name) => Boolean(UNIT[name]?.startsWith("°"));
// The unit behind a number: "°/tile" and "tiles" are said in words.
export const unitText = (unit) => unit.replace(/tiles?/, (word) => say(`units.${word}`));
export const quantity = (name, x) => (isAngle(name) ? fixed(x, 1) + unitText(UNIT[name]) : UNIT[name] === "tiles" ? tilesText(x) : brief(x));
// A number, or a direction's three. Lengths are without their unit.
export const briefly = (name, x) => (Array.isArray(x) ? `(${x.map(brief).join(separator())})` : isAngle(name) ? quantity(name, x) : brief(x));

export const prismsText = (n) => say("counts.prisms", { count: n, number: n });
export const tilesText = (x, text = brief) => say("counts.tiles", { count: Number(x.toPrecision(3)), number: text(x) });

// A complex number. Both parts have the same number of decimals, so that the larger has five digits at most.
export function point(a) {
  if (!finite(a)) return "∞";
  const decimals = Math.max(0, 3 - Math.floor(Math.log10(Math.max(1, Math.abs(a[0]), Math.abs(a[1])))));
  const [re, im] = a.map((x) => fixed(x, decimals));
  return `${re} ${im.startsWith("−") ? "−" : "+"} ${im.replace("−", "")} i`;
}

export const timesText = (x) => printed(x < 1e4 ? x.toPrecision(3) : x.toExponential(2));
export const placeText = (point) => point.map((x) => fixed(x, 2)).join(separator());
