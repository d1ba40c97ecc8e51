// Measuring on the picture: a protractor with two arms, whose ends are a ruler's too, and a table of what a class has measured, over
// the curves of the equations. Points are in tiles of the window's plane.

import { radians } from "../liveview/geometry.js";
import { onArrows, onDrag } from "../liveview/pointer.js";
import { hasPiece } from "../liveview/presets.js";
import { abs, arg, finite, minus, plus, quotient, scaled } from "./complex.js";
import { $, clamped, element, on, pick, refresh, write } from "./data.js";
import { csvOf, keep, saveTable, work } from "./kept.js";
import { angle, brief, fixed, localised, printed, readNumber, say, SETTINGS, SYMBOL, tilesText } from "./language.js";
import { apparentPosition, appearance, moment } from "./moment.js";
import { outlineOf } from "./outline.js";
import { onStage, tilePixels } from "./overlay.js";
import { bare, placeSaid } from "./phrases.js";
import { arc, curve, dot, heading, line, step, words } from "./shapes.js";
import { kinds, session, state, usesAlpha } from "./state.js";

const FARTHEST = [2.4, 1.8];  // from the picture's middle
/** @type {Record<string, any>} */
const points = { A: [0, -0.75], B: [0, 0.35], C: [0.6, 0.2] };
// without alpha or N where the sheets have none; M is a text where it was typed
/** @type {{sheets: string[], N: number | null, alpha: number | null, z1: number, z2: number, d?: number, nu: string, M: string | number}[]} */
export const rows = work.rows;

// What the tool measures: the angle from the arm AB to the arm AC, counter-clockwise, and the lengths of both.
function measured() {
  const [b, c] = [minus(points.B, points.A), minus(points.C, points.A)];
  return { angle: arg(quotient(c, b)), AB: abs(b), AC: abs(c) };
}

// The height of the piece in tiles, as its outline says; 0 for spheres, and while the outline is not known.
function height() {
  const ys = hasPiece(state.scene) ? outlineOf(state.piece).flat().map(([, y]) => y) : [];
  return ys.length ? Math.max(...ys) - Math.min(...ys) : 0;
}

// The simple level has one size: that compared with the size without sheets. M is compared with the size in the window.
const isSimple = () => state.level === "simple";
const sizeName = () => (isSimple() ? say("page.size") : "M");
const unit = (values) => (isSimple() ? bare(values) : 1);

let level = "";  // of the rows that are shown
let shown = false;
let placed = "";    // the settings for which the points were placed
let written = "";   // the settings of the last row, until a point is moved
let told = "";      // the settings whose answer is shown
const present = () => JSON.stringify(pick(state, "scene", ...SETTINGS));
export const pointsAsked = () => (shown && placed !== present() ? [say("measure.move_first")] : []);
const isNew = () => placed === present() && written !== placed;

export function drawMeasure(now) {
  const on = session.measuring && state.question < 0;
  if (on && !shown) {
    lay(now, [0.6, 0.95]);
    [placed, session.answered] = ["", false];
  }
  shown = on;
  $("tool").toggleAttribute("hidden", !on);
  for (const name of Object.keys(points)) $(`point-${name}`).hidden = !on;
  if (!on) return;
  if (session.answered && told !== present()) {  // the answer of other settings is not asked for
    session.answered = false;
    refresh();
  }
  $("write-down").setAttribute("aria-disabled", !isNew());  // not `disabled`: it keeps the focus
  $("move-first").style.visibility = isNew() ? "hidden" : "";  // it keeps its room, so that the buttons stay where they are
  write("move-first", rows.length && written && written === placed && placed === present() ? lastRow() : say("measure.move_first"));
  $("tell").setAttribute("aria-pressed", session.answered);
  const [A, B, C] = [points.A, points.B, points.C].map(onStage), { angle: found, AB, AC } = measured();
  const radius = Math.min(0.5 * abs(minus(B, A)), 0.5 * abs(minus(C, A)), 0.6 * tilePixels()), start = heading(A, B);
  const { clientWidth: width, clientHeight: all } = $("stage"), rem = Math.max(12, all / 36);
  const away = heading(A, C) + (found < 0 ? -1 : 1) * (Math.PI / 2);  // from the angle
  $("tool").setAttribute("viewBox", `${-width / 2} ${-all / 2} ${width} ${all}`);
  $("tool").style.fontSize = `${rem}px`;
  $("tool").replaceChildren(
    ...[B, C].flatMap((end) => [line("halo", A, end), line("arm", A, end)]), ...ticks(points.A, points.C), arc("halo", A, radius, start, found), arc("arm", A, radius, start, found),
    // numbers of other settings, or of points that nobody has placed, would be taken for what is seen
    ...(placed !== present() ? [] : [words("reading", step(A, start + found / 2, 1.35 * radius), angle(found)), words("reading", step(scaled(0.5, plus(A, C)), away, (1.2 + 2 * Math.abs(Math.cos(away))) * rem), tilesText(AC))]),
    ...Object.keys(points).flatMap((name, n) => [dot("end", [A, B, C][n], 5), words("reading", step([A, B, C][n], n ? Math.PI / 2 : -Math.PI / 2, rem), name)]),
  );
  for (const [name, place] of Object.entries(points)) {
    const [x, y] = onStage(place);
    $(`point-${name}`).style.transform = `translate(${x}px, ${y}px)`;
    $(`point-${name}`).setAttribute("aria-label", say("measure.point", { name, place: placeSaid(place) }));
  }
  const tall = height(), size = AC / tall;
  write("readings", placed !== present() ? "" : say("measure.readings", { angle: angle(found), AB: tilesText(AB), AC: tilesText(AC) })
    + (tall ? ` ${say(`measure.height${isSimple() ? "" : "_and_M"}`, { tiles: tilesText(tall), without: tilesText(tall * bare(now)), M: fixed(size, 2), times: fixed(size / bare(now), 2) })}` : ""));
  if (level !== state.level) drawRows();
  drawPlots(now);
}

// Put A on the object's foot, B above it, and C at an aside from it.
function lay({ place }, aside) {
  if (!finite(place) || place.some((x, k) => Math.abs(x) > FARTHEST[k])) return;
  Object.assign(points, { A: place, B: plus(place, [0, abs(aside)]), C: plus(place, aside) });
}

$("reset").addEventListener("click", () => (shown = false));  // the points are laid anew

// The ruler's marks: one each tenth of a tile.
function ticks(from, to) {
  const way = minus(to, from), length = abs(way), aside = scaled(1 / length, [-way[1], way[0]]);
  return Array.from({ length: Math.min(60, Math.floor(length * 10)) }, (_, k) => {
    const place = plus(from, scaled((k + 1) / (10 * length), way));
    return line("arm", onStage(place), onStage(plus(place, scaled((k + 1) % 10 ? 0.04 : 0.09, aside))));
  });
}

const placeAnew = () => ([placed, written] = [present(), ""]);
const move = (name, to) => {
  points[name] = to.map((x, k) => clamped(x, [-FARTHEST[k], FARTHEST[k]]));
  placeAnew();
  refresh();
};
for (const name of Object.keys(points)) {
  const handle = $(`point-${name}`);
  onDrag(handle, (event) => {
    event.stopPropagation();  // it is not the picture that is dragged
    const from = points[name], before = [placed, written];
    return (way) => {
      move(name, plus(from, scaled(1 / tilePixels(), way)));
      if (!abs(way)) [placed, written] = before;  // it is back where it was
    };
  });
  onArrows(handle, (step, { shiftKey }) => move(name, plus(points[name], scaled(shiftKey ? 0.1 : 0.01, step))));
}

// ---- The table ----

const QUANTITIES = ["sheets", "N", "alpha", "z1", "z2", "nu", "M", "size"];
const read = (given) => readNumber(String(given));
const rounded = (x) => Number(x.toFixed(2));

$("write-down").addEventListener("click", () => {
  if (!isNew()) return write("spoken", say("measure.move_first"));
  const { angle: found, AC } = measured(), tall = height();
  const { z1, z2, d, glass } = moment(), sheets = kinds();
  const row = { d, sheets, N: glass ? state.prisms : null, alpha: sheets.some(usesAlpha) ? state.alpha : null, z1, z2, nu: fixed(found / radians(1), 1), M: tall ? AC / tall : "" };
  rows.push(row);
  keep();
  written = placed;
  $("spoken").textContent = lastRow();
  drawRows();
});
on("tell", "click", () => {
  session.answered = !session.answered;
  told = present();
  requestAnimationFrame(() => session.answered && $("sentence").scrollIntoView({ block: "nearest" }));
});
on("put-on", "click", () => {
  const now = moment(), tall = height() || now.radii[now.objects.indexOf(now.z1)];
  lay(now, minus(apparentPosition(now, plus(now.L, [0, tall])), now.place));
  placeAnew();
});

// What the last row says.
function lastRow() {
  const row = rows.at(-1), M = read(row.M) / unit(row);
  return say("measure.written", { n: rows.length, nu: `${row.nu}°`, name: sizeName(), M: Number.isFinite(M) ? fixed(M, 2) : "" });
}

export function drawRows() {
  level = state.level;
  $("rows").replaceChildren(...rows.map((row, n) => {
    const field = (name, symbol, scale = 1) => {
      const isScaled = (x) => scale !== 1 && Number.isFinite(x), shown = read(row[name]) / scale;
      const value = localised((isScaled(shown) || typeof row[name] === "number" ? shown.toFixed(2) : row[name]).replace(",", ".")), ariaLabel = say("measure.field", { name: symbol, n: n + 1 });
      return element("input", { className: "field", value, autocomplete: "off", ariaLabel, oninput: ({ target }) => {
        const typed = readNumber(target.value) * scale;
        row[name] = isScaled(typed) ? String(Number(typed.toFixed(4))) : target.value;
        keep();
        refresh();
      } });
    };
    const remove = element("button", { type: "button", className: "what", ariaLabel: say("measure.remove", { n: n + 1 }), onclick: () => {
      rows.splice(n, 1);
      written = "";
      keep();
      drawRows();
      $("write-down").focus({ preventScroll: true });
    } }, "×");
    const sheets = row.sheets.map((name) => say(`kinds.${name}.choice`)).join(" + ");
    const numbers = ["N", "alpha", "z1", "z2"].map((name) => (row[name] === null ? "–" : printed(String(Number(row[name].toPrecision(4))))));
    return element("tr", {}, ...[sheets, ...numbers, field("nu", "ν"), field("M", sizeName(), unit(row)), remove].map((content) => element("td", {}, content)));
  }));
  $("save-csv").disabled = !rows.length;
  $("measure-help").hidden = rows.length > 0;  // its room is for the rows
  refresh();
}

// Each number is rounded once, as the page shows it. `size` is compared with that without sheets.
const table = () => [QUANTITIES, ...rows.map(({ sheets, nu, M, ...row }) => Object.values({
  sheets: sheets.join("+"), ...pick(row, "N", "alpha", "z1", "z2"), nu: read(nu), M: typeof M === "number" ? rounded(M) : read(M), size: rounded(read(M) / bare(row)),
}))];
export const csv = () => csvOf(table());
$("save-csv").addEventListener("click", () => saveTable("povgen.csv", table()));

// ---- The measured numbers over the curves ----

// What changes between the rows: alpha, unless only a distance does.
function abscissa() {
  const changes = (name) => new Set(rows.map((row) => row[name]).filter(Number.isFinite)).size > 1;
  return changes("alpha") ? "alpha" : changes("z1") ? "z1" : changes("z2") ? "z2" : "alpha";
}

const ENDS_OF_NU = [30, 90, 180];
const ENDS = { alpha: [-180, 180], z1: [0.3, 30], z2: [0.5, 30] };

function drawPlots(now) {
  const x = abscissa();
  for (const [name, id] of [["nu", "plot-nu"], ["M", "plot-M"]]) drawPlot($(id), name, x, now);
}

// The equation's curve for the present values, and the points. Hollow points have other values than the curve.
function drawPlot(plot, name, x, now) {
  const { clientWidth: width, clientHeight: all } = plot;
  if (!width) return;
  const there = rows.filter((row) => Number.isFinite(row[x]));
  const reached = [...ENDS[x], ...there.map((row) => row[x])];
  const [least, most] = [Math.min(...reached), Math.max(...reached)], log = x !== "alpha";
  const [left, right, top, bottom] = [30, width - 8, 16, all - 22];
  const present = { alpha: state.alpha, z1: now.z1, z2: now.z2 };
  const seen = (value) => {
    const values = { ...present, [x]: value }, { nu, M } = appearance({ ...now, ...values, alpha: radians(values.alpha) });
    return name === "nu" ? nu / radians(1) : M / unit({ ...now, ...values });
  };
  const points = now.two && rows.length ? Array.from({ length: 181 }, (_, k) => (log ? least * (most / least) ** (k / 180) : least + ((most - least) * k) / 180)) : [];
  const angles = [...points.map((value) => seen(value)), ...there.map(({ nu }) => read(nu) || 0)].map(Math.abs);
  const end = ENDS_OF_NU.find((limit) => limit === 180 || angles.every((each) => !(each > limit))), scale = name === "nu" ? [-end, end] : [0, 3];
  const share = (value) => (log ? Math.log(value / least) / Math.log(most / least) : (value - least) / (most - least));
  /** @type {(value: number, shown: number) => any} */
  const to = (value, shown) => [left + share(value) * (right - left), bottom - ((shown - scale[0]) / (scale[1] - scale[0])) * (bottom - top)];
  const inside = points.map((value) => [value, seen(value)]).map(([value, shown], n, all) =>
    (shown >= scale[0] && shown <= scale[1] && !(n && Math.abs(shown - all[n - 1][1]) > 180) ? to(value, shown) : null));
  const same = (row) => String(row.sheets) === String(kinds()) && Object.keys(present).every((other) => other === x || Math.abs(row[other] - present[other]) < 1e-3 * Math.max(1, Math.abs(present[other])));
  const marks = there.filter((row) => Number.isFinite(read(row[name])) && String(row[name]).trim())
    .map((row) => dot(`mark${same(row) ? "" : " other"}`, to(row[x], clamped(read(row[name]) / (name === "nu" ? 1 : unit(row)), /** @type {any} */ (scale))), 4));
  plot.setAttribute("viewBox", `0 0 ${width} ${all}`);
  plot.replaceChildren(
    line("axis", [left, bottom], [right, bottom]), line("axis", [left, bottom], [left, top]),
    ...(name === "nu" ? [line("axis", to(least, 0), to(most, 0))] : [line("axis", to(least, 1), to(most, 1))]),
    words("scale", [left, all - 10], brief(least)), words("scale", [right - 8, all - 10], brief(most)), words("scale", [(left + right) / 2, all - 9], `${SYMBOL[x]} / ${x === "alpha" ? "°" : say("units.tiles")}`),
    ...(name === "nu" ? [-end, 0, end] : [0, 1, 2, 3]).map((value) => words("scale", [15, to(least, value)[1]], fixed(value, 0))),
    words("scale", [left + 16, 8], name === "nu" ? "ν / °" : sizeName()), curve("curve", inside), ...marks,
  );
  plot.setAttribute("aria-label", say(rows.length ? "measure.plot" : "measure.plot_empty", { name: name === "nu" ? "ν" : sizeName(), x: SYMBOL[x], number: marks.length, value: now.two ? (name === "nu" ? angle(now.nu) : fixed(now.M / unit(now), 2)) : "–" }));
}
