// The work of a lesson: measurements, votes and answers. The browser keeps it for the page's address, also of a file.

import { $, element } from "./data.js";
import { localised, say, separator } from "./language.js";

// Votes and answers are by the names of the questions. An answer: the last prediction; whether the first one was right, null if
// the answer was shown without one; and whether it is shown. `own`: the texts of a teacher's own questions among them.
// `student`: whose work it is.
/** @type {{ student: string, rows: any[], votes: Record<string, number[][]>, own: Record<string, { ask: string, choices: string[] }>, answers: Record<string, { given: string | null, first: boolean | null, shown: boolean }> }} */
export const work = { student: "", rows: [], votes: {}, answers: {}, own: {} };
export const storage = { refused: false };

export const key = () => `povgen ${location.pathname}`;
export const isEmpty = () => !work.rows.length && !Object.keys({ ...work.votes, ...work.answers }).length;

// Take what has been kept, in place of the present work.
export function take() {
  let kept = null;
  try {
    kept = JSON.parse(globalThis.location && localStorage.getItem(key()));
  } catch { /* nothing has been kept, or the browser refuses */ }
  const { student = "", rows = [], votes = {}, answers = {}, own = {} } = kept ?? {};
  work.rows.splice(0, Infinity, ...rows);
  Object.assign(work, { student, votes, answers, own });
}

export function keep() {
  try {
    localStorage.setItem(key(), JSON.stringify(work));
    storage.refused = false;
  } catch {
    storage.refused = true;
  }
}

// A value that this tab keeps while the page is loaded again. Without a new one, return it; "" if there is none.
/** @type {(name: string, value?: string) => string} */
export function inTab(name, value) {
  try {
    if (value !== undefined) sessionStorage.setItem(`${key()} ${name}`, value);
    return sessionStorage.getItem(`${key()} ${name}`) ?? "";
  } catch {  // the browser refuses
    return "";
  }
}

// A table as CSV. Where the decimal sign is a comma, spreadsheets part columns by semicolons.
export function csvOf(rows) {
  const mark = separator().trim();
  const cell = (value) => (typeof value === "string" ? (/[",;\n]/.test(value) ? `"${value.replaceAll('"', '""')}"` : value) : Number.isFinite(value) ? localised(String(value)) : "");
  return rows.map((row) => row.map(cell).join(mark)).join("\r\n");
}

// With whose work it is, if that was said. The mark at the beginning tells spreadsheets that it is UTF-8.
export function saveTable(download, rows) {
  const named = work.student ? rows.map((row, n) => [n ? work.student : "student", ...row]) : rows;
  element("a", { href: `data:text/csv;charset=utf-8,${encodeURIComponent(`\ufeff${csvOf(named)}`)}`, download }).click();
  $("spoken").textContent = say("kept.saved", { file: download });
}

export function clear() {
  work.rows.splice(0);
  Object.assign(work, { student: "", votes: {}, answers: {}, own: {} });
  keep();
}

// A page that is opened asks its questions anew, as a second class needs it. One that is loaded again shows what it showed.
take();
const [opening] = globalThis.performance?.getEntriesByType("navigation") ?? [];
const how = /** @type {any} */ (opening)?.type;
export const isReloaded = how === "reload";
if (how === "navigate") for (const answer of Object.values(work.answers)) answer.shown = false;
