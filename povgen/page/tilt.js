// The eye follows the tilt of a phone: parallax by moving the phone, not by dragging.

import { radians } from "../liveview/geometry.js";
import { minus, plus, scaled, times, turn } from "./complex.js";
import { $, refresh } from "./data.js";
import { say } from "./language.js";
import { player } from "./player.js";
import { change, state } from "./state.js";
import { tour } from "./tour.js";

const TILES = 0.05;   // for a degree
const PATIENCE = 1500;  // ms until the phone must have said how it is tilted

/** @type {any} */
let first = null;  // the tilt and the eye when it began
let timer = 0;

// The eye as the phone sees it, in degrees to its right and up: if its right edge goes back, the eye is to its left.
const seenFrom = ({ beta, gamma }) => times(turn(radians(screen.orientation?.angle ?? 0)), [-gamma, beta]);

function follow(event) {
  if (event.beta === null) return;
  clearTimeout(timer);
  if (tour.step >= 0) return;  // it moves the eye itself
  first ??= { tilt: seenFrom(event), E: state.E };
  player.pause();
  change({ E: plus(first.E, scaled(TILES, minus(seenFrom(event), first.tilt))) });
  refresh();
}

function stop(said = "") {
  removeEventListener("deviceorientation", follow);
  clearTimeout(timer);
  $("tilt").setAttribute("aria-pressed", "false");
  $("copied").textContent = said;
}

$("tilt").hidden = typeof DeviceOrientationEvent === "undefined" || !matchMedia("(pointer: coarse)").matches;
$("tilt").addEventListener("click", async () => {
  if ($("tilt").getAttribute("aria-pressed") === "true") return stop();
  $("tilt").setAttribute("aria-pressed", "true");
  first = null;
  /** @type {any} */
  const asked = DeviceOrientationEvent;
  const answer = await asked.requestPermission?.().catch(() => "denied");  // Safari asks its user
  if (answer === "denied") return stop(say("share.no_tilt"));
  $("copied").textContent = say("share.tilt_help");
  addEventListener("deviceorientation", follow);
  timer = setTimeout(() => stop(say("share.no_tilt")), PATIENCE);
});
