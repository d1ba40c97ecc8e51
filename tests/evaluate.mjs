// Evaluates JavaScript with the names of the page's modules, for test_javascript.py: a line of JSON with the script and its
// argument, as source text, gives a line of JSON. The first lines are the page's data and
// the modules as one script.

import { createInterface } from "node:readline";

// JSON has no such numbers: test_javascript.py reads them from this text
const special = (key, value) => (typeof value === "number" && !Number.isFinite(value) ? `number ${value}` : value);

const lines = createInterface({ input: process.stdin })[Symbol.asyncIterator]();
const { value: textContent } = await lines.next();
globalThis.document = { getElementById: () => ({ textContent }) };
const { value: script } = await lines.next();
globalThis.window = globalThis;
(0, eval)(JSON.parse(script));
const { povgen } = globalThis;
const pages = Object.keys(povgen).filter((name) => !["geometry", "sheets", "presets"].includes(name));
Object.assign(globalThis, povgen, ...pages.map((name) => povgen[name]));
for await (const line of lines) {
  const { script, argument } = JSON.parse(line);
  const found = (0, eval)(`(${script})`);
  console.log(JSON.stringify({ found: typeof found === "function" ? found((0, eval)(`(${argument})`)) : found }, special));
}
