// Evaluates JavaScript with the names of the page's modules, for test_javascript.py: a line of JSON with the script and its
// argument, as source text, gives a line of JSON. The first line is the page's data.

import { createInterface } from "node:readline";

// JSON has no such numbers: test_javascript.py reads them from this text
const special = (key, value) => (typeof value === "number" && !Number.isFinite(value) ? `number ${value}` : value);

const lines = createInterface({ input: process.stdin })[Symbol.asyncIterator]();
const { value: textContent } = await lines.next();
globalThis.document = { getElementById: () => ({ textContent }) };
const names = ["live/geometry", "demo/equations", "demo/numbers", "demo/text", "demo/address", "demo/state", "demo/moment", "demo/contents", "demo/questions"];
const modules = await Promise.all(names.map((name) => import(`../../templates/${name}.js`)));
names.forEach((name, k) => (globalThis[name.split("/")[1]] = modules[k]));
Object.assign(globalThis, ...modules.slice(1));
for await (const line of lines) {
  const { script, argument } = JSON.parse(line);
  const found = (0, eval)(`(${script})`);
  console.log(JSON.stringify({ found: typeof found === "function" ? found((0, eval)(`(${argument})`)) : found }, special));
}
