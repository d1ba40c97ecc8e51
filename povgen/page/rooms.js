// Rooms: windows and objects that stand anywhere, from examples, a link or a file that povgen reads too (docs/rooms.md). A dialog
// shows them. The page behind it stays as it is.

import { onArrows, onDrag } from "../liveview/pointer.js";
import { steppedEye } from "../liveview/presets.js";
import { still } from "../liveview/readout.js";
import { LiveView } from "../liveview/view.js";
import { $, data, element, on, refresh, wrapped } from "./data.js";
import { printPicture } from "./handouts.js";
import { brief, fixed, listed, say, separator } from "./language.js";
import { ofKind, pieceName } from "./phrases.js";
import { player } from "./player.js";
import { drawing, Fault, fonts, roomOf, withNumbers } from "./roomFile.js";
import { scrambled, unscrambled } from "./scramble.js";
import { session, usesAlpha } from "./state.js";
import { tour } from "./tour.js";

const SLIDERS = ["alpha", "yaw", "pitch"];  // of a window
const STEP = 0.05;  // tiles: of the eye, for an arrow key; with Shift five times as far

let open = "";       // the room that is shown, as the address has it
/** @type {any} */
let room = null;     // what its file states
/** @type {any} */
let view = null;
let scene = null;    // a function that makes the view's scene
let message = "";    // what is wrong with a file
let failure = "";    // why there is no picture

export const roomView = () => view;
// In a narrower picture as much is seen from side to side as in one of 4:3.
const now = () => {
  const made = withNumbers(room, session.moved), { clientWidth: width, clientHeight: height } = $("rooms-area");
  return { ...made, eye: { ...made.eye, view: made.eye.view * Math.max(1, width && (4 / 3) * (height / width)) } };
};
const textOf = (name) => data.rooms.examples[name] ?? unscrambled(name);

// ---- Opening and closing ----

// Show the room of an example's name or of a link's code. What cannot be read leaves all as it is, and says so.
function begin(name) {
  try {
    room = roomOf(read(name));
    [open, message] = [name, ""];
    $("rooms-eye").textContent = "";
  } catch (error) {
    refuse(error);
    session.room = open;
    return;
  }
  const choices = room.windows.map(({ name }, value) => element("option", { value, textContent: name }));
  $("rooms-window").replaceChildren(...(choices.length > 1 ? [element("option", { value: "all" })] : []), ...choices);
  $("rooms-window").value = Math.max(0, room.windows.findIndex(({ yaw, pitch }) => yaw || pitch));
  const own = room;
  fonts().then(() => own === room && draw());
  showDialog();
}

function read(name) {
  try {
    return textOf(name);
  } catch {
    throw new Fault(say("rooms.cut"));
  }
}

function refuse(error, file = "") {
  if (!(error instanceof Fault)) throw error;
  message = file + error.message;
  showDialog();
}

function showDialog() {
  tour.leave();
  player.pause();
  if (!$("rooms").open) $("rooms").showModal();
}

// A view of its own for each room: it has the room's pieces and pictures.
function draw() {
  const { volumes, scene: made } = drawing(room), canvas = element("canvas");
  view?.close();
  scene = made;
  $("rooms-area").replaceChildren(canvas);
  view = new LiveView(canvas, scene(now()), volumes, (why, reason = "") => {
    failure = why ? say(`failures.${why}`, { reason }) : "";
    refresh();
  });
}

async function take(file) {
  if (!file) return;
  try {
    const text = await file.text();
    roomOf(text);
    [session.room, session.moved] = [scrambled(text), {}];
  } catch (error) {
    refuse(error, `${file.name}: `);
  }
  refresh();
}

function choose(name) {
  [session.room, session.moved] = [name, {}];
  refresh();
}

function end() {
  $("rooms").close();
  view?.close();
  room = view = scene = null;
  $("rooms-area").replaceChildren();
  [open, message, failure] = ["", "", ""];
  choose("");
}
$("rooms").addEventListener("close", () => $("rooms").open || end());  // it may be open again
$("rooms-open").addEventListener("click", () => {
  $("share-open").click();  // its sheet closes
  $("share-open").focus();  // the dialog gives it back
  choose(Object.keys(data.rooms.examples)[0]);
});
$("rooms-choice").addEventListener("change", () => choose($("rooms-choice").value));
$("rooms-file").addEventListener("change", () => {
  take($("rooms-file").files[0]);
  $("rooms-file").value = "";
});
const save = (href, download) => element("a", { href, download }).click();
$("rooms-save").addEventListener("click", () => save(`data:text/plain,${encodeURIComponent(textOf(open))}`, "room.toml"));
// Do something with a picture, at least so wide.
function picture(least, action) {
  if (!view?.gl) return;
  const { width, height } = view.canvas, wide = Math.max(least, width);
  action(still(view, wide, Math.round((wide * height) / width)).toDataURL("image/png"));
}
$("rooms-picture").addEventListener("click", () => picture(1920, (made) => save(made, "room.png")));
$("rooms-print").addEventListener("click", () => printPicture());
addEventListener("beforeprint", () => picture(0, (made) => ($("rooms-printed").src = made)));
addEventListener("dragover", (event) => event.dataTransfer?.types.includes("Files") && event.preventDefault());
addEventListener("drop", (event) => {
  if (!event.dataTransfer?.files.length) return;
  event.preventDefault();
  take(event.dataTransfer.files[0]);
});

// ---- What is moved ----

const moveEye = (from, step) => {
  const eye = steppedEye(from, step);
  for (const axis of ["x", "y", "z"]) session.moved[`eye.${axis}`] = eye[axis];
  refresh();
};
onArrows($("rooms-area"), (step, { shiftKey }) => {
  if (!room) return;
  moveEye(now(), step.map((x) => x * STEP * (shiftKey ? 5 : 1)));
  $("rooms-eye").textContent = say("rooms.eye_is", { place: place(now().eye) });
});
onDrag($("rooms-area"), () => {
  if (!room) return undefined;
  const from = now(), tiles = from.eye.view / $("rooms-area").clientHeight;
  return (way) => moveEye(from, way.map((x) => x * tiles));
});

function chosen({ windows }) {
  const { value } = $("rooms-window");
  return value === "all" ? windows : windows.filter((_, k) => k === Number(value));
}
for (const name of SLIDERS) {
  on(`rooms-${name}`, "input", () => {
    for (const each of chosen(room)) session.moved[`${each.name}.${name}`] = Number($(`rooms-${name}`).value);
  });
}
on("rooms-window", "change", () => {});
on("rooms-reset", "click", () => {
  session.moved = {};
  $("rooms-eye").textContent = say("rooms.eye_is", { place: place(room.eye) });
  $("rooms-choice").focus();  // the button has nothing to do now
});

// ---- What is said ----

const degrees = (angle) => `${fixed(angle, 1)}°`;
/** @type {(of: any) => string} */
const place = ({ x, y, z }) => `(${[x, y, z].map(brief).join(separator())})`;
const NAMES = {
  piece: ({ piece }) => pieceName(piece),
  sphere: () => pieceName("sphere"),
  text: ({ text }) => `“${text}”`,
  floor: () => say("share.floor"),
};
const called = (each) => (NAMES[each.kind] ?? (({ kind }) => say(`rooms.things.${kind}`)))(each);

// What stands in the room, where, and how it is turned.
/** @type {(room: any) => string} */
function described({ eye, windows, objects }) {
  const said = windows.map((each) => {
    const { name, sheet } = each, alpha = usesAlpha(sheet) ? [`α = ${degrees(each.alpha)}`] : [];
    const turns = [say("rooms.turned", { angle: degrees(each.yaw) }), say("rooms.tilted", { angle: degrees(each.pitch) })];
    return say("rooms.window_is", { name, sheet: ofKind(sheet, "choice"), place: place(each), angles: listed([...alpha, ...turns]) });
  });
  const things = objects.map((each) => (each.kind === "floor" ? called(each) : `${called(each)} ${place(each)}`));
  if (things.length) said.push(say("rooms.objects_are", { list: listed(things) }));
  return [say("rooms.axes"), say("rooms.eye_is", { place: place(eye) }), ...said].join(" ");
}

export function drawRoom() {
  if (session.room !== open) {
    if (session.room) begin(session.room);
    else end();
  }
  $("rooms-message").textContent = [message, failure].filter(Boolean).join(" ");
  $("rooms-panel").hidden = !room;
  if (!room) return;
  const shown = now();
  if (view) view.set(scene(shown));
  const own = !(open in data.rooms.examples);
  $("rooms-choice").value = own ? "own" : open;
  const textContent = typeof room.title === "string" ? room.title : say("rooms.own");
  Object.assign($("rooms-choice").lastElementChild, { hidden: !own, textContent });
  const [first] = $("rooms-window").options;
  if (first?.value === "all") first.textContent = say("rooms.all");
  const several = chosen(shown);
  for (const name of SLIDERS) {
    const [each] = several.filter(({ sheet }) => name !== "alpha" || usesAlpha(sheet));
    $(`rooms-row-${name}`).hidden = !each || (name !== "alpha" && several.length > 1);
    if (!each) continue;
    $(`rooms-${name}`).value = wrapped(each[name]);
    $(`rooms-${name}`).setAttribute("aria-valuetext", degrees(each[name]));
    $(`rooms-is-${name}`).textContent = degrees(each[name]);
  }
  $("rooms-reset").disabled = !Object.keys(session.moved).length;
  $("rooms-says").textContent = described(shown);
  const same = !own && Object.keys(session.moved).every((name) => name.startsWith("eye."));  // what is said does not hold for others
  const turn = shown.windows.length && shown.windows.every(({ sheet }) => ["ideal", "detailed"].includes(sheet)) ? say("rooms.turns") : "";
  $("rooms-look").textContent = same ? say(`rooms.look.${open}`) : turn;
}
