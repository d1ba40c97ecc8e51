// The page's sentences, in the language that is chosen: the tables of languages/. Plurals, numbers and lists are the browser's.

import { data } from "./data.js";

export const LANGUAGES = Object.keys(data.languages);

let table, plurals, list, decimal;
// the language that is chosen, and whether a user or an address has chosen it, not the browser
export const spoken = { language: "", asked: false };

// Choose a language by its name, as "en".
export function choose(language, asked = false) {
  Object.assign(spoken, { language, asked });
  table = data.languages[language];
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
  const value = values[name], text = typeof value === "object" ? value[form] : value;
  // among letters from right to left, a number with its signs stays as it is: a mark from left to right is on both its sides
  return table.dir === "rtl" && !/[\u0590-\u08ff]/.test(text) ? `\u200e${text}\u200e` : text;
});

// The forms of a thing's name.
export function forms(name, values = {}) {
  return Object.fromEntries(Object.entries(entry(`things.${name}`)).map(([form, text]) => [form, filled(text, values)]));
}

export const percent = (share) => new Intl.NumberFormat(table.locale, { style: "percent" }).format(share);
export const listed = (parts) => list.format(parts);

// A number's digits, as toFixed writes them, with the language's decimal sign.
export const localised = (digits) => digits.replace(".", decimal);
// Between the numbers of a list, where a comma can be a number's own.
export const separator = () => (decimal === "," ? "; " : ", ");

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
