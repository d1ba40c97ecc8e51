// The three movies as presets: one quantity changes from a start to a stop. And POV-Ray's own movies.

import { hasPiece } from "../liveview/presets.js";
import { $, clamped, data, element, refresh, write } from "./data.js";
import { brief, quantity, say, SYMBOL } from "./language.js";
import { change, chosenBeyond, OPENING, replace, session, START, state, usesAlpha } from "./state.js";

const SLOWER = 4;  // how many times as long a movie takes, if it is to be slow
export const reducedMotion = matchMedia("(prefers-reduced-motion: reduce)");

export const player = {
  preset: data.presets[0], playing: false, since: 0, asked: 0,

  // The ends of the movie. Some sheets have their own.
  ends() {
    const { log, parameter } = this.preset;
    const [start, stop] = data.kinds[state.sheet]?.sweep[parameter] ?? [this.preset.start, this.preset.stop];
    return { start, stop, log, parameter };
  },

  // What moves in it, in words.
  from() {
    const { parameter, start, stop } = this.ends();
    return say("controls.scrub", { symbol: SYMBOL[parameter], start: quantity(parameter, start), stop: quantity(parameter, stop) });
  },

  value(part) {
    const { start, stop, log } = this.ends();
    return log ? start * (stop / start) ** part : start + (stop - start) * part;
  },

  // The part of the movie at which the swept quantity has its present value.
  part() {
    const { start, stop, log, parameter } = this.ends();
    const x = state[parameter];
    return clamped(log ? Math.log(x / start) / Math.log(stop / start) : (x - start) / (stop - start), [0, 1]) || 0;
  },

  seek(part) {
    change({ [this.preset.parameter]: this.value(part) });
    refresh();
  },

  choose(preset) {
    this.pause();
    this.preset = preset;
    replace(this.fixed(state.sheet === "detailed" ? "detailed" : "ideal"), [preset.parameter]);
    this.seek(0);
    if (!reducedMotion.matches) this.play();
  },

  // What a preset fixes.
  fixed(sheet) {
    const { scene, fixed } = this.preset;
    return { alpha: OPENING.alpha, z2: OPENING.z2, ...START[scene], ...fixed, scene, sheet, windows: 1, prisms: OPENING.prisms, piece: OPENING.piece, E: [0, 0], pupil: 0 };
  },

  play() {
    if (this.preset.scene !== state.scene) return;
    $("hint").hidden = true;
    if (this.preset.parameter === "alpha" && !usesAlpha(state.sheet)) replace({ sheet: "ideal" });
    if (this.part() >= 1) this.seek(0);
    this.playing = true;
    this.since = performance.now();
    this.next();
    $("spoken").textContent = `${say("page.play")}: ${this.from()}`;
    refresh();
  },

  pause() {
    if (!this.playing) return;
    this.playing = false;
    refresh();
  },

  stop() {
    this.pause();
    this.seek(0);
  },

  tick(time) {
    if (!this.playing) return;
    // with reduced motion the picture jumps every second
    const step = (time - this.since) / 1000 / this.preset.seconds / ($("slow").checked ? SLOWER : 1);
    if (!reducedMotion.matches || time - this.since > 1000) {
      this.since = time;
      const part = this.part() + Math.max(0, step);
      if (part < 1) this.seek(part);
      else if ($("loop").checked) this.seek(0);
      else {
        this.seek(1);
        this.pause();
      }
    }
    this.next();
  },

  // There is one loop of frames, however often the movie is started.
  next() {
    cancelAnimationFrame(this.asked);
    this.asked = requestAnimationFrame((time) => this.tick(time));
  },

  // A preset is for a scene: another scene takes its own. A sheet beyond the paper that has no alpha takes another parameter.
  // A step of a lesson takes what it is about.
  follow() {
    const isMoot = ({ parameter }) => parameter === "alpha" && state.sheet in data.kinds && !usesAlpha(state.sheet);
    if (this.preset.scene !== state.scene) this.reset();
    if (isMoot(this.preset)) this.preset = data.presets.find((preset) => preset.scene === state.scene && !isMoot(preset)) ?? this.preset;
    this.preset = data.presets.find(({ scene, parameter }) => scene === state.scene && parameter === session.about) ?? this.preset;
  },

  reset() {
    this.pause();
    this.preset = data.presets.find(({ scene }) => scene === state.scene);
  },

  draw({ z1, z2 }) {
    const { parameter, start, stop } = this.ends(), x = { ...state, z1, z2 }[parameter];
    for (const button of $("presets").children) {
      button.setAttribute("aria-pressed", data.presets[button.value] === this.preset && chosenBeyond() === "none");
    }
    $("play").setAttribute("aria-label", say(this.playing ? "page.pause" : "page.play"));
    $("play-icon").setAttribute("d", this.playing ? "M1 0H4V10H1ZM6 0H9V10H6Z" : "M1 0L10 5L1 10Z");
    $("scrub").disabled = parameter === "alpha" && ["none", "single"].includes(state.sheet);
    $("scrub").value = 1000 * this.part();
    $("scrub").setAttribute("aria-label", this.from());
    $("scrub").setAttribute("aria-valuetext", quantity(parameter, x));
    // beyond the movie's ends the slider does not stand where the value is
    const isIn = Math.abs(this.value(this.part()) - state[parameter]) < 1e-6 * Math.abs(stop - start);
    write("scrub-value", isIn ? `${SYMBOL[parameter]} = ${parameter === "alpha" ? quantity(parameter, x) : brief(x)}` : "");
  },
};

for (const [n, { name, scene, parameter }] of data.presets.entries()) {
  const button = element("button", { type: "button", value: n, id: `preset-${name}`, onclick: () => player.choose(data.presets[n]) });
  Object.assign(button.dataset, { say: hasPiece(scene) ? "controls.vary" : "controls.vary_spheres", symbol: SYMBOL[parameter] });
  $("presets").append(button);
}
// While the page is hidden no frames are drawn: the movie then goes on where it was.
document.addEventListener("visibilitychange", () => (player.since = performance.now()));
$("play").addEventListener("click", () => (player.playing ? player.pause() : player.play()));
$("stop").addEventListener("click", () => player.stop());
$("scrub").addEventListener("input", () => {
  player.pause();
  player.seek($("scrub").value / 1000);
});

// ---- POV-Ray's picture: the movie's frame at the same value ----

export const povray = {
  shown: false, broken: new Set(),

  movie() {
    const { movie } = player.preset;
    return movie && !this.broken.has(movie.file) ? movie : null;
  },

  toggle() {
    this.shown = !this.shown;
    if (this.shown) replace({ ...this.wanted(), [player.preset.parameter]: player.value(player.part()) }, ["sheet"]);
    refresh();
  },

  // The movie shows its own scene only, without a curtain.
  wanted: () => ({ ...player.fixed("detailed"), compare: "off" }),

  matches() {
    const wanted = this.wanted();
    delete wanted[player.preset.parameter];
    return Object.entries(wanted).every(([name, value]) => String(value) === String(state[name]));
  },

  draw() {
    const movie = this.movie();
    const video = $("video");
    const instead = document.body.classList.contains("failed");
    if (!movie || (!instead && !this.matches())) this.shown = false;
    if (instead && movie) this.shown = true;
    $("povray").hidden = !movie || instead;
    $("povray").setAttribute("aria-pressed", this.shown);
    video.hidden = !this.shown || video.readyState < 2;
    if (!this.shown) return;
    if (video.getAttribute("src") !== movie.file) video.setAttribute("src", movie.file);
    const frame = Math.round(player.part() * (movie.frames - 1));
    const time = ((frame + 0.5) / movie.frames) * video.duration;
    if (Number.isFinite(time) && Math.abs(video.currentTime - time) > 1e-3 && !video.seeking) video.currentTime = time;
  },
};

$("povray").addEventListener("click", () => povray.toggle());
for (const event of ["loadedmetadata", "loadeddata", "seeked"]) $("video").addEventListener(event, () => povray.draw());
$("video").addEventListener("error", () => {
  povray.broken.add($("video").getAttribute("src"));
  refresh();
});
