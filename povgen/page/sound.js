// The angle nu and the size of the object as a tone, for those who do not see. It sounds for a moment after each change.

import { $, clamped, refresh } from "./data.js";
import { contents } from "./moment.js";
import { bare } from "./phrases.js";
import { isToBeFound } from "./text.js";

const MIDDLE = 440, OCTAVE = Math.PI / 2;  // Hz at nu = 0; radians
const SECONDS = 0.4, LOUDNESS = 0.15;      // of an object that is as large as without sheets; 1 is the loudest

/** @type {{ tone: any, volume: any, told: string }} */
export const sound = { tone: null, volume: null, told: "" };

$("sound").addEventListener("click", () => {
  if (sound.tone) {
    sound.tone.context.close();
    sound.tone = null;
  } else {
    const context = new AudioContext();
    Object.assign(sound, { tone: context.createOscillator(), volume: context.createGain(), told: "" });
    sound.volume.gain.value = 0;
    sound.tone.connect(sound.volume).connect(context.destination);
    sound.tone.start();
  }
  $("sound").setAttribute("aria-pressed", String(Boolean(sound.tone)));
  $("sound-help").hidden = !sound.tone;
  refresh();
});

export function tell(now) {
  const { turned = now.nu } = now, size = now.M / bare(now), told = `${turned} ${size}`;
  if (!sound.tone || told === sound.told || isToBeFound() || !Number.isFinite(turned + size) || !contents(now).has("thing")) return;
  sound.told = told;
  sound.tone.frequency.value = MIDDLE * 2 ** (turned / OCTAVE);
  const { gain, context: { currentTime } } = sound.volume;
  gain.cancelScheduledValues(currentTime);
  gain.setTargetAtTime(clamped(LOUDNESS * size, [0.02, 1]), currentTime, 0.02);
  gain.setTargetAtTime(0, currentTime + SECONDS, 0.05);
}
