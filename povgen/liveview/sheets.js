// The sheets in the windows. What an ideal sheet does to light is its law, which Python, POV-Ray and the shaders read too.

import { LAWS } from "./laws.js";

const KINDS = Object.keys(LAWS);
// The greatest number of constants of a law.
export const CONSTANTS = Math.max(1, ...KINDS.map((name) => LAWS[name].count));

const radians = (degrees) => degrees * (Math.PI / 180);

// Whether a window's sheets consist of prisms, or of lenses.
export const hasPrisms = ({ sheet }) => ["detailed", "single", "lenticular", "profile"].includes(sheet);

// The number of a window's law: `bent` in laws.glsl. -1: prisms or lenses; -2: no sheet.
export const kind = (window) => (hasPrisms(window) ? -1 : window.sheet === "none" ? -2 : KINDS.indexOf(lawOf(window)));

// The name of a window's law.
function lawOf({ sheet, values }) {
  const name = sheet === "law" ? `law ${values.law}` : sheet;
  if (!LAWS[name]) throw new Error(`sheet = ${sheet}: unknown`);
  return name;
}

// What depends on the parameters of a window's law alone.
export function constants(window) {
  const law = LAWS[lawOf(window)];
  const numbers = { ...window.values.parameter };
  for (const [name, [parameter, unit, component]] of Object.entries(law.numbers)) {
    const value = window.values[parameter];
    numbers[name] = component === null ? (unit === "degrees" ? radians(value) : value) : value[component];
  }
  return law.constants(numbers);
}

// A map from the slope of an eye's ray that meets an ideal sheet, and the place, to the slope behind it; null if no light passes.
export function bending(window) {
  const { bend } = LAWS[lawOf(window)], c = constants(window);
  return ([sx, sy], [X, Y]) => {
    const length = Math.hypot(sx, sy, 1);
    const [x, y, z] = bend(sx / length, sy / length, 1 / length, X, Y, c);
    return z > 1e-6 * Math.hypot(x, y, z) ? [x / z, y / z] : null;
  };
}
