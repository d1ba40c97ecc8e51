// Dragging the object and the eye, in the picture and in the diagram; and moving them by the arrow keys.

import { onArrows, onDrag } from "../liveview/pointer.js";
import { hasPiece } from "../liveview/presets.js";
import { abs, conj, determinant, finite, minus, plus, resolved, scaled } from "./complex.js";
import { $, clamped, refresh } from "./data.js";
import { orientation } from "./diagram.js";
import { say } from "./language.js";
import { apparentPosition, appearance, moment, objectStep, outside } from "./moment.js";
import { onStage, stage, tilePixels } from "./overlay.js";
import { placeSaid } from "./phrases.js";
import { player, povray } from "./player.js";
import { change, FLOOR, session, state } from "./state.js";

const KEY_STEP = 0.05;  // tiles; with Shift five times as far

// The place in the plane z = 0, in tiles, of a point of the stage.
const placeAt = ([x, y]) => scaled(1 / tilePixels(), [x, -y]);
const pointerAt = (event, box) => [event.clientX - box.left - box.width / 2, event.clientY - box.top - box.height / 2];

// What a pointer takes hold of in the picture: the object's image, or else the eye.
function underPointer(event, at, now) {
  const handle = event.target.closest(".handle");
  if (state.light === "aim" && handle?.dataset.moves !== "W" && !outside(placeAt(at), now.scene)) change({ W: placeAt(at) });
  if (state.light === "aim" && (handle?.dataset.moves === "W" || !outside(placeAt(at), now.scene))) return "W";
  if (handle && (state.position || handle.dataset.moves === "L")) return handle.dataset.moves;  // otherwise the eye's is not seen
  if (!hasPiece(state.scene)) {
    const found = sphereAt(at, now);
    if (found === undefined) return "E";
    change({ z1: now.objects[found] });
    return "L";
  }
  const path = $("image");
  const near = finite(now.place) && abs(minus(onStage(now.place), at)) < 0.06 * stage.clientHeight;
  return near || path?.isPointInFill(new DOMPoint(...at)) ? "L" : "E";
}

// The number of the nearest sphere whose image is at a point, or undefined.
function sphereAt(at, now) {
  const gaps = now.objects.map((z1, k) => {
    const there = { ...now, z1 };
    const place = apparentPosition(there);
    return finite(place) ? abs(minus(onStage(place), at)) - tilePixels() * now.radii[k] * appearance(there).M : Infinity;
  });
  const least = Math.min(...gaps);
  return least < 12 ? gaps.indexOf(least) : undefined;
}

let tapped = { time: -Infinity, at: [0, 0] };  // when and where the picture was last pressed

function holdInPicture(event) {
  if (povray.shown || event.target.id === "curtain") return undefined;
  const at = pointerAt(event, stage.getBoundingClientRect()), before = { ...state };
  const what = underPointer(event, at, moment());
  const again = event.timeStamp - tapped.time < 350 && abs(minus(at, tapped.at)) < 24;
  tapped = { time: event.timeStamp, at };
  if (again && what === "E") {  // a double tap beside the object
    player.pause();
    change({ E: [0, 0] });
    refresh();
  }
  const now = moment();
  return hold(event, what, (way) => {
    const tiles = scaled(1 / tilePixels(), way);
    return what !== "L" ? tiles : objectStep(now, tiles);
  }, {}, before);
}

function holdInDiagram(event) {
  const handle = event.target.closest(".handle");
  const map = session.diagramMap;
  return handle ? hold(event, handle.dataset.moves, (way) => scaled(1 / map.tile, way), { map }) : undefined;
}

// In the light's view, a pointer moves the eye or the object along two of the axes x, y and z: those that are seen best from there.
function holdInSpace(event) {
  const what = event.target.closest("[data-moves]")?.dataset.moves, view = session.spaceView;
  if (!what) return undefined;
  const seen = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis) => conj(minus(view.to(axis), view.to([0, 0, 0]))));
  const area = (axes) => Math.abs(determinant(axes.map((k) => seen[k])));
  const axes = [[2, 1], [2, 0], [0, 1]].reduce((one, other) => (area(other) > area(one) ? other : one));
  return hold(event, what, (way) => {
    const step = [0, 0, 0];
    resolved(way, axes.map((k) => seen[k])).forEach((x, n) => (step[axes[n]] = x));
    return step;
  }, { view });
}

// While it is held, the pointer's way in pixels becomes a step of L or E in tiles: to the right, up and, if it is said, away from the eye.
function hold(event, what, toTiles, kept, before = { ...state }) {
  event.preventDefault();
  document.activeElement.blur();
  const handle = event.target.closest(".handle"), from = state[what];
  if (handle?.dataset.moves === what) handle.focus({ preventScroll: true });  // it would lie behind the picture
  player.pause();
  session.held = { what, ...kept, before };
  const [depth, away] = what === "E" ? ["z2", -1] : ["z1", 1];
  document.body.classList.add("dragging");
  $("hint").hidden = true;
  return (way) => {
    const step = toTiles(way), z = step.length > 2 ? { [depth]: before[depth] + away * step[2] } : {};
    change({ [what]: plus(from, step), ...z });
    refresh();
  };
}

function release({ type }) {
  // the drag is taken back, with what began it
  if (["pointercancel", "pointerdown"].includes(type) && session.held) change(session.held.before);
  session.held = null;
  document.body.classList.remove("dragging");
  refresh();
}

onDrag(stage, holdInPicture, release);
onDrag($("diagram-box"), holdInDiagram, release);
onDrag($("space-turn"), holdInSpace, release);

for (const handle of document.querySelectorAll(".handle[data-moves]")) {
  onArrows(handle, (step, { shiftKey }) => {
    const { moves } = handle.dataset;
    $("hint").hidden = true;
    player.pause();
    change({ [moves]: plus(state[moves], scaled(KEY_STEP * (shiftKey ? 5 : 1), step)) });
    refresh();
  });
}

// Put the handles where the eye and the object's image are; at the border if they are outside.
export function placeHandles(now) {
  const inside = ([x, y], { clientWidth: width, clientHeight: height }) =>
    [clamped(x, [20 - width / 2, width / 2 - 20]), clamped(y, [20 - height / 2, height / 2 - 20])];
  const put = (id, at, box) => {
    const [x, y] = inside(at, box);
    $(id).style.transform = `translate(${x}px, ${y}px)`;
    const sentence = `controls.${id.replace("-picture", "").replace("-", "_")}`;
    $(id).setAttribute("aria-label", say(sentence, { place: placeSaid(state[$(id).dataset.moves]) }));
  };
  const inPicture = { eye: now.E, object: finite(now.place) ? now.place : [0, 0], aim: state.W }, inDiagram = { eye: [1, 0], object: [0, 0] };
  for (const [name, place] of Object.entries(inPicture)) put(`${name}-picture`, onStage(place), stage);
  // the piece, where it is in the window; one sheet shows what is far upside down
  const { nu, turned = nu, M, z1, z2 } = now, isSeen = hasPiece(state.scene) && finite(now.place) && !outside(now.place, now.scene), picture = $("object-picture").style;
  picture.transform += ` rotate(${state.sheet === "single" && z1 > z2 ? Math.PI : -(turned || 0)}rad)`;
  picture.setProperty("--tile", `${isSeen ? Math.min(M * tilePixels(), 0.4 * stage.clientHeight) : 0}px`);
  picture.setProperty("--pedestal", state.L[1] - FLOOR);
  $("aim-picture").hidden = state.light !== "aim";
  for (const [name, place] of Object.entries(inDiagram)) {
    $(`${name}-diagram`).hidden = orientation() !== "picture";
    if (orientation() === "picture" && session.diagramMap) put(`${name}-diagram`, session.diagramMap.at(place), $("diagram-box"));
  }
}
