// Numbers, as the page prints them and as it reads them.

import { radians } from "../live/geometry.js";
import { finite } from "./complex.js";
import { data } from "./data.js";

const ofSheets = (what) => Object.fromEntries(Object.entries(data.parameters).map(([name, parameter]) => [name, parameter[what]]));
export const SYMBOL = { ...ofSheets("symbol"), z1: "z₁", z2: "z₂", prisms: "N", windows: "The number of windows", alpha2: "α₂", d: "d" };
const UNIT = { ...ofSheets("unit"), z1: "tiles", z2: "tiles", alpha2: "°", d: "tiles" };

// The names of the settings that can be replaced.
export const SETTINGS = { ...SYMBOL, L: "L", E: "E", piece: "piece", sheet: "sheets", windows: "windows" };

const raised = (n) => [...String(n)].map((digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit] ?? "⁻").join("");

// The number that someone has typed, with a decimal point or comma, as a fraction, or with a unit. NaN if it is none.
export function readNumber(text) {
  const plain = text.replaceAll(",", ".").replaceAll("−", "-").replace(/(°|degrees?|tiles?|times)\s*$/, "");
  const parts = plain.split("/");
  if (parts.length > 2 || !parts.every((part) => part.trim())) return NaN;
  const [above, below = 1] = parts.map(Number);
  return above / below;
}

// The text of toFixed, toPrecision or toExponential with typographic signs. A number that rounds to 0 has no sign.
export function printed(text) {
  const [digits, power] = text.replace(/^-/, "").split("e");
  const sign = text.startsWith("-") && Number(digits) ? "−" : "";
  return sign + digits + (power ? ` × 10${raised(Number(power))}` : "");
}

export const fixed = (x, digits) => printed(Math.abs(x) < 1e5 ? x.toFixed(digits) : x.toExponential(2));
export const size = (x) => (Number.isFinite(x) ? printed(x < 1e4 ? x.toPrecision(4) : x.toExponential(2)) : "∞");
export const brief = (x) => (Number.isFinite(x) ? printed(String(Number(x.toPrecision(3)))) : "∞");
export const rough = (x) => printed(String(Number(x.toPrecision(2))));
export const angle = (x) => (Number.isNaN(x) ? "undefined" : `${fixed(x / radians(1), 1)}°`);


export const isAngle = (name) => Boolean(UNIT[name]?.startsWith("°"));
export const quantity = (name, x) => (isAngle(name) ? fixed(x, 1) + UNIT[name] : `${size(x)} ${UNIT[name] ?? ""}`.trim());
// A number, or a direction's three. Lengths are without their unit.
export const briefly = (name, x) => (Array.isArray(x) ? `(${x.map(brief).join(", ")})` : isAngle(name) ? quantity(name, x) : brief(x));

export const prismsText = (n) => (n === 1 ? "1 prism" : `${n} prisms`);

// A complex number. Both parts have the same number of decimals, so that the larger has five digits at most.
export function point(a) {
  if (!finite(a)) return "∞";
  const decimals = Math.max(0, 3 - Math.floor(Math.log10(Math.max(1, Math.abs(a[0]), Math.abs(a[1])))));
  const [re, im] = a.map((x) => fixed(x, decimals));
  return `${re} ${im.startsWith("−") ? "−" : "+"} ${im.replace("−", "")} i`;
}

export const timesText = (x) => printed(x < 1e4 ? x.toPrecision(3) : x.toExponential(2));
export const placeText = (point) => point.map((x) => fixed(x, 2)).join(", ");
