// The sheets in the windows. What an ideal sheet does to light is its law, which Python, POV-Ray and the shaders read too.

import { LAWS } from "./laws.js";

const KINDS = Object.keys(LAWS);
// The greatest number of constants of a law.
export const CONSTANTS = Math.max(1, ...KINDS.map((name) => LAWS[name].count));

const radians = (degrees) => degrees * (Math.PI / 180);

/** The windows, the nearest to the eye first: the kind of their sheets, z, and the values of all parameters.
 * What a window does not state is that of the first one.
 * @returns {any[]} */
export function windows(scene) {
  const further = scene.window.map((window) => {
    const given = Object.fromEntries(Object.entries(window).filter(([, value]) => value !== null));
    return { ...scene, ...given };
  });
  return [{ ...scene, z: 0 }, ...further].map((values) => ({ sheet: values.sheet, z: values.z, values }));
}

// Whether a window's sheets consist of prisms, or of lenses.
export const hasPrisms = ({ sheet }) => ["detailed", "single", "lenticular", "profile"].includes(sheet);

// The windows in front of all prisms, if one of them has a sheet. Ideal sheets come first.
export function idealWindows(scene) {
  const found = windows(scene).filter((window) => !hasPrisms(window));
  return found.every(({ sheet }) => sheet === "none") ? [] : found;
}

// The number of a window's law: `bent` in laws.glsl. Prisms have none.
export function kind(window) {
  if (hasPrisms(window)) return -1;
  const number = KINDS.indexOf(window.sheet === "law" ? `law ${window.values.law}` : window.sheet);
  if (number < 0) throw new Error(`sheet = ${window.sheet}: unknown`);
  return number;
}

// What depends on the parameters of a window's law alone.
export function constants(window) {
  const law = LAWS[KINDS[kind(window)]];
  const numbers = { ...window.values.parameter };
  for (const [name, [parameter, unit, component]] of Object.entries(law.numbers)) {
    const value = window.values[parameter];
    numbers[name] = component === null ? (unit === "degrees" ? radians(value) : value) : value[component];
  }
  return law.constants(numbers);
}

// A map from the slope of an eye's ray that meets an ideal sheet, and the place, to the slope behind it; null if no light passes.
export function bending(window) {
  const { bend } = LAWS[KINDS[kind(window)]], c = constants(window);
  return ([sx, sy], [X, Y]) => {
    const length = Math.hypot(sx, sy, 1);
    const [x, y, z] = bend(sx / length, sy / length, 1 / length, X, Y, c);
    return z > 1e-6 * Math.hypot(x, y, z) ? [x / z, y / z] : null;
  };
}
