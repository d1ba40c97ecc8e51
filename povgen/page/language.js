// The page's sentences, in the language that is chosen: the tables of languages/. Also how numbers are written and
// read. Plurals and lists are the browser's.

import { radians } from "../liveview/geometry.js";
import { finite } from "./complex.js";
import { data } from "./data.js";

export const LANGUAGES = Object.keys(data.languages);

const isTouched = globalThis.matchMedia?.("(pointer: coarse)").matches;
let table, plurals, list, decimal;
// the language that is chosen, and whether a user or an address has chosen it, not the browser
export const spoken = { language: "", asked: false };

// Choose a language by its name, as "en".
export function choose(language, asked = false) {
  Object.assign(spoken, { language, asked });
  // keys are said only where something else than a finger points
  table = JSON.parse(JSON.stringify(data.languages[language]).replace(/<keys>(.*?)<\/keys>/g, isTouched ? "" : "$1"));
  plurals = new Intl.PluralRules(table.locale);
  list = new Intl.ListFormat(table.locale);
  decimal = new Intl.NumberFormat(table.locale).formatToParts(1.5).find(({ type }) => type === "decimal").value;
}
// Choose the browser's language.
export function chooseUsual() {
  const wanted = (globalThis.navigator?.languages ?? []).map((name) => name.split("-")[0]);
  choose(wanted.find((name) => LANGUAGES.includes(name)) ?? "en");
}
chooseUsual();

// What a table has under a key, as "page.title".
export function entry(key) {
  return key.split(".").reduce((part, name) => part?.[name], table);
}

// A sentence. `values` replace the words in braces: texts, or things with their forms (`thing`). Of a sentence with plurals,
// the number `count` chooses one.
export function say(key, values = {}) {
  const found = entry(key);
  const text = typeof found === "object" && !Array.isArray(found) ? found[plurals.select(values.count)] ?? found.other : found;
  if (typeof text !== "string") throw new Error(`no sentence: ${key}`);
  return filled(text, values);
}

const filled = (text, values) => text.replace(/\{([\w/]+)(?:\.(\w+))?\}/g, (_, name, form = "name") => {
  const value = values[name];
  return isolated(typeof value === "object" ? value[form] : value);
});

// Among letters from right to left, a text has its own direction, so that a number keeps its signs. Letters alone join others.
export const isolated = (text) => (table.dir === "rtl" && /[^\u0600-\u06ff\s]/.test(text) ? `\u2068${text}\u2069` : text);

// The forms of a thing's name.
export function forms(name, values = {}) {
  return Object.fromEntries(Object.entries(entry(`things.${name}`)).map(([form, text]) => [form, filled(text, values)]));
}

export const percent = (share) => new Intl.NumberFormat(table.locale, { style: "percent" }).format(share);
export const listed = (parts) => list.format(parts.map(isolated));

// A number's digits, as toFixed writes them, with the language's decimal sign.
export const localised = (digits) => digits.replace(".", decimal);
// Between the numbers of a list, where a comma can be a number's own.
export const separator = () => (decimal === "," ? "; " : ", ");

// Equations are not parted at a line's end.
export const unbroken = (text) => text.replaceAll(" = ", "\u00a0=\u00a0");

// Write the sentences into the page: the attributes `data-say`, `data-say-label` and `data-say-title` name them.
export function fill() {
  document.documentElement.lang = spoken.language;
  document.documentElement.dir = table.dir;
  document.title = say("page.title");
  for (const part of document.querySelectorAll("[data-say]")) part.innerHTML = marked(say(part.dataset.say, part.dataset));
  for (const part of document.querySelectorAll("[data-say='page.source'] i")) part.lang = "en";  // the title of the paper
  for (const part of document.querySelectorAll("[data-say-label]")) part.setAttribute("aria-label", say(part.dataset.sayLabel, part.dataset));
  for (const part of document.querySelectorAll("[data-say-title]")) part.title = say(part.dataset.sayTitle, part.dataset);
}

// HTML of a sentence: of its tags, those of symbols and keys count.
export const marked = (text) => text.replaceAll("&", "&amp;").replace(/<(?!\/?(i|sub|sup|kbd)>)/g, "&lt;");

// ---- Numbers, as the page prints them and as it reads them ----

const ofSheets = (what) => Object.fromEntries(Object.entries(data.parameters).map(([name, parameter]) => [name, parameter[what]]));
/** @type {Record<string, string>} */
export const SYMBOL = { ...ofSheets("symbol"), z1: "z₁", z2: "z₂", prisms: "N", alpha2: "α₂", d: "d", pupil: "p", focus: "s" };
const UNIT = { ...ofSheets("unit"), z1: "tiles", z2: "tiles", alpha2: "°", d: "tiles", pupil: "tiles", focus: "tiles", L: "tiles", E: "tiles" };

// The settings that can be replaced.
export const SETTINGS = [...Object.keys(SYMBOL), "L", "E", "piece", "sheet", "sheet2", "windows"];

const raised = (n) => [...String(n)].map((digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit] ?? "⁻").join("");

const NUMBER = "[+-]?(?:\\d+\\.?\\d*|\\.\\d+)(?:e[+-]?\\d+)?";
const TYPED = new RegExp(`^(${NUMBER})(?:\\s*/\\s*(${NUMBER}))?\\s*(.*)$`, "i");

// What someone has typed: a number x with a decimal point or comma, or a fraction, in any digits, NaN if it is none; and of the
// names in `units.typed`, those that the unit behind it can be, which may be half typed; and whether it is an `other` unit.
export function typedNumber(text) {
  const plain = text.replace(/[\u200e\u200f\u061c\u2066-\u2069\u066c]/g, "").replace(/[\u0660-\u0669\u06f0-\u06f9]/g, (digit) => String(digit.charCodeAt(0) % 16))
    .replace(/[,\u060c\u066b]/g, ".").replace(/[−–]/g, "-");
  const [, above, below = "1", rest = ""] = TYPED.exec(plain.trim()) ?? [], unit = rest.replace(/^°.*/, "deg").toLowerCase();
  const begins = ([, words]) => words.toLowerCase().split(" ").some((word) => word.startsWith(unit));
  const known = [data.languages.en.units.typed, entry("units.typed")].flatMap(Object.entries);
  const units = unit ? known.filter(begins).map(([name]) => name) : [];
  const other = Boolean(unit && !units.length);
  return { x: other ? NaN : Number(above) / Number(below), units, other };
}
export const readNumber = (text) => typedNumber(text).x;
// Whether a text may become a number.
export const beginsNumber = (text) => /^[\s.,\u060c\u066b+−–-]*$/.test(text);

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

// The unit in which a quantity is typed, a name in `units.typed`; "" if it has none.
export const typedUnit = (name) => (isAngle(name) ? "degrees" : UNIT[name] ?? "");
export const isAngle = (name) => Boolean(UNIT[name]?.startsWith("°"));
// The unit behind a number: "°/tile" and "tiles" are said in words.
export const unitText = (unit) => unit.replace(/tiles?/, (word) => say(`units.${word}`));
export const quantity = (name, x) => (isAngle(name) ? fixed(x, 1) + unitText(UNIT[name]) : UNIT[name] === "tiles" ? tilesText(x) : brief(x));
// The same, of an angle without zeros.
export const withUnit = (name, x) => (isAngle(name) ? brief(x) + unitText(UNIT[name]) : quantity(name, x));
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
