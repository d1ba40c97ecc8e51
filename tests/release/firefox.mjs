// Firefox, driven by lines of JSON: each line is a method of Puppeteer's page and its arguments; its result is a line.
// The arguments: the folder with puppeteer-core, and Firefox's program.
import { createRequire } from "node:module";
import { createInterface } from "node:readline";

const [folder, executablePath] = process.argv.slice(2);
const puppeteer = createRequire(`${folder}/`)("puppeteer-core");
// Firefox draws with WebGL in software only if it is told to.
const extraPrefsFirefox = { "webgl.force-enabled": true, "webgl.disabled": false };
const browser = await puppeteer.launch({ browser: "firefox", executablePath, headless: false, extraPrefsFirefox });
const page = await browser.newPage();
const said = [];
page.on("console", (message) => said.push(message.text()));
page.on("pageerror", (error) => said.push(String(error)));
page.on("request", (request) => /^(data|file):/.test(request.url()) || said.push(request.url()));
const press = (key) => page.keyboard.press(key);
const methods = { said: () => said, press, evaluate: (text) => page.evaluate(text) };
for await (const line of createInterface({ input: process.stdin })) {
  const [name, ...values] = JSON.parse(line);
  const result = await (methods[name] ?? page[name].bind(page))(...values);
  console.log(JSON.stringify(name in methods ? (result ?? null) : null));
}
await browser.close();
