// Numbers and sentences, as the page prints them.

const SYMBOL = { alpha: "α", z1: "z₁", z2: "z₂", prisms: "N", windows: "The number of windows", alpha2: "α₂", d: "d", ratio: "|η|" };

// The names of the settings that can be replaced.
const SETTINGS = {
  ...pick(SYMBOL, "alpha", "z1", "z2", "prisms", "alpha2", "d", "ratio"), L: "L", E: "E", axis: "axis", piece: "piece", sheet: "sheets", windows: "windows",
};

const raised = (n) => [...String(n)].map((digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit] ?? "⁻").join("");

// The number that someone has typed, with a decimal point or comma, as a fraction, or with a unit. NaN if it is none.
function readNumber(text) {
  const plain = text.replaceAll(",", ".").replaceAll("−", "-").replace(/(°|degrees?|tiles?|times)\s*$/, "");
  const parts = plain.split("/");
  if (parts.length > 2 || !parts.every((part) => part.trim())) return NaN;
  const [above, below = 1] = parts.map(Number);
  return above / below;
}

// The text of toFixed, toPrecision or toExponential with typographic signs. A number that rounds to 0 has no sign.
function printed(text) {
  const [digits, power] = text.replace(/^-/, "").split("e");
  const sign = text.startsWith("-") && Number(digits) ? "−" : "";
  return sign + digits + (power ? ` × 10${raised(Number(power))}` : "");
}

const fixed = (x, digits) => printed(Math.abs(x) < 1e5 ? x.toFixed(digits) : x.toExponential(2));
const size = (x) => (Number.isFinite(x) ? printed(x < 1e4 ? x.toPrecision(4) : x.toExponential(2)) : "∞");
const brief = (x) => (Number.isFinite(x) ? printed(String(Number(x.toPrecision(3)))) : "∞");
const rough = (x) => printed(String(Number(x.toPrecision(2))));
const angle = (x) => (Number.isNaN(x) ? "undefined" : `${fixed(x / radians(1), 1)}°`);
const quantity = (name, x) => (name.startsWith("alpha") ? `${fixed(x, 1)}°` : name === "ratio" ? size(x) : `${size(x)} tiles`);

const prismsText = (n) => (n === 1 ? "1 prism" : `${n} prisms`);

// A complex number. Both parts have the same number of decimals, so that the larger has five digits at most.
function point(a) {
  if (!finite(a)) return "∞";
  const decimals = Math.max(0, 3 - Math.floor(Math.log10(Math.max(1, Math.abs(a[0]), Math.abs(a[1])))));
  const [re, im] = a.map((x) => fixed(x, decimals));
  return `${re} ${im.startsWith("−") ? "−" : "+"} ${im.replace("−", "")} i`;
}

// ---- Sentences ----

const pieceName = (piece) => piece.split("/").pop().replace(/\.\w+$/, "");
const thing = () => (state.scene === "spheres" ? "sphere" : pieceName(state.piece));

function turnedBy(nu) {
  const text = angle(Math.abs(nu));
  return text === "0.0°" ? "not turned" : `turned by ${text}${text === "180.0°" ? "" : nu > 0 ? " counter-clockwise" : " clockwise"}`;
}

const timesText = (x) => printed(x < 1e4 ? x.toPrecision(3) : x.toExponential(2));

// What is seen, in a sentence or two. While a question is asked, the class is to find it.
function explanation(now) {
  if (isAsked()) return ["What is seen is said with the answer.", ...limitsMet(now)].join(" ");
  const first = QUESTIONS[state.question]?.says?.(now);
  return [...(first ? [first] : []), seen(now), ...remarks(now)].join(" ");
}

const doubt = (now) => "Here the prediction can be wrong by "
  + `${possibleError(now) < 1280 ? `up to ${rough(possibleError(now))} pixels of 1280x960` : "more than the picture’s width"}: `
  + "the prisms are large, those of two sheets are nearly parallel, or the pole is near.";

function seen(now) {
  if (now.beyond) return seenThrough(now);
  const { sheet, M, nu, height, z1, z2 } = now;
  const large = `${timesText(M)} times as large as if it stood in the window`;
  if (sheet === "single" && !Number.isFinite(height)) {
    return `z₁ = z₂: one height fills the window from top to bottom, that of the eye. What is there is ${timesText(M)} times as wide as if it`
      + " stood in the window.";
  }
  if (now.nearPole) return poleSentence(now);
  if (!contents(now).has("thing")) return absent(now);
  if (sheet === "none") return `Nothing is in the window: the ${thing()} is seen as it is, ${large}.`;
  if (sheet === "single") {
    const across = `${timesText(M)} times as wide and ${timesText(height)} times as high as if it stood in the window`;
    return `One sheet mirrors up and down in the light's direction: the ${thing()} appears ${across}`
      + `${z1 > z2 ? ", and upside down" : ""}.`;
  }
  if (sheet === "detailed" && unsure(now)) return doubt(now);
  const which = state.scene === "spheres" ? `The sphere at z₁ = ${brief(z1)} appears, about E, ` : `The ${thing()} appears `;
  return `${which}${turnedBy(nu)}, and ${large}.`;
}

function poleSentence(now) {
  const { M, seen } = now;
  const exact = !Number.isFinite(M), name = thing();
  const pole = exact ? "The pole" : "Near the pole";
  const part = exact ? "one point, straight before the eye" : `a part that is only ${rough(seen)} tiles wide`;
  if (imagingPole(now.scene, now.z1, now.z2) === "line") {
    return `The pole: all light to the eye passes the ${name}’s plane in a line at ${fixed(now.degrees / 2, 1)}°, through the point straight before the eye.`
      + (contents(now).has("thing") ? " Each of its points is drawn out across the window." : ` ${absent(now)}`);
  }
  if (!contents(now).has("thing") && !contents(now).has("pedestal")) {
    return `${pole}: all light to the eye passes the ${name}’s plane in ${part}. The ${name} is not there: the window shows ${windowShows(now)}.`;
  }
  if (!contents(now).has("thing")) return `${pole}: of the pedestal, ${part}, fills the window. Nothing of the ${name} is seen.`;
  return exact
    ? `The pole: one point of the ${name} fills the whole window, the point straight before the eye.`
    : `Near the pole: a part of the ${name}’s plane that is only ${rough(seen)} tiles wide fills the window.`;
}

// Which values were not allowed.
function limitsMet({ z1, z2, d, scene }) {
  const depth = geometry.depth(scene);
  const frame = depth > 1 ? `the frame, which is ${brief(depth)} tiles deep` : "the frame";
  const met = [...refusals];
  if (state.scene === "chess" && state.z1 < z1 * 0.999) met.push(`z₁ is at least ${brief(z1)}: the piece would touch ${frame}.`);
  if (d && state.d < d * 0.999) met.push(`d is at least ${brief(d)}: the windows would touch.`);
  if (state.z2 < z2 * 0.999) met.push(`z₂ is at least ${brief(z2)}: the eye would be too near ${frame}.`);
  return met;
}

function remarks(now) {
  const { sheet, z1, z2, scene, degrees } = now;
  const found = [];
  if (now.two && Math.abs(Math.abs(degrees) - 180) < 0.05 && z1 < z2 * 0.95 && contents(now).has("thing")) {
    found.push(`It floats ${brief(z1)} tiles in front of the window: move the eye and watch.`);
  }
  const limits = limitsMet(now);
  if (OTHER_SHEETS.includes(sheet) && !finite(now.place) && !now.nearPole && contents(now).has("thing")) {
    const filled = contents(now).size === 1 ? `The ${thing()} fills the window` : `Parts of the ${thing()} are in the window`;
    limits.push(`${filled}, but no path of light from L to the eye was found.`);
  }
  if (limits.length) found.push(...limits);
  else if (!now.nearPole && !unsure(now) && finite(now.place) && outside(now.place, scene) && contents(now).has("thing")) {
    found.push(`P is outside the window, so ${thing() === "sphere" ? "this sphere’s middle" : `the ${thing()}’s foot`} is not seen.`);
  }
  const names = replacedNames();
  const one = names.length === 1 && !["sheet", "windows"].includes(names[0]);
  if (names.length) found.push(`Your ${listed(names.map((name) => SETTINGS[name]))} ${one ? "is" : "are"} replaced.`);
  if (sheet === "detailed" && unsure(now) && !(now.M <= NEAR_POLE) && !now.beside) found.push(doubt(now));
  return found;
}

const placeText = (point) => point.map((x) => fixed(x, 2)).join(", ");

// The description of the picture for those who do not see it.
function describe(now) {
  const several = now.Z ? `, with a second window ${brief(now.d)} tiles behind the first one and α₂ = ${fixed(state.alpha2, 1)}°` : "";
  const model = {
    none: "without sheets", single: `through one sheet of ${prismsText(now.scene.prisms)}`, ideal: "through the ideal sheet",
    detailed: `through two sheets of ${prismsText(now.scene.prisms)}`,
  }[now.sheet] ?? { axis: "through an ideal sheet that rotates light about an axis", refraction: "through an ideal sheet that refracts",
    lenslets: "through ideal lenslets", mirror: "through an ideal sheet that mirrors" }[now.sheet];
  return `A ${thing()} seen ${model}${several}. α = ${fixed(now.degrees, 1)}°, z₁ = ${size(now.z1)} and z₂ = ${size(now.z2)} tiles.`
    + ` The object L is at ${placeText(now.L)}, the eye E at ${placeText(now.E)}. ${explanation(now)}`;
}

// The parts of the caption on the picture.
function caption(now) {
  const sheets = { axis: "axis", refraction: "refraction", lenslets: "lenslets", mirror: "mirror", none: "no sheet", single: `one sheet, N = ${now.scene.prisms}`, detailed: `N = ${now.scene.prisms}`, ideal: "ideal sheet" };
  const parts = [sheets[now.sheet], `z₁ = ${brief(now.z1)}`, `z₂ = ${brief(now.z2)}`];
  if (!now.two && !now.beyond) return parts;
  if (now.Z) parts.splice(1, 0, ...(now.sheet === "none" ? [] : [`α₂ = ${fixed(state.alpha2, 1)}°`]), `d = ${brief(now.d)}`);
  if (now.sheet !== "none") parts.splice(1, 0, `α = ${fixed(now.degrees, 1)}°`);
  if (OTHER_SHEETS.includes(now.sheet)) {
    const own = { axis: `axis ${placeText(state.axis)}`, refraction: `|η| = ${brief(state.ratio)}`, lenslets: `|η| = ${brief(state.ratio)}` }[now.sheet];
    return [...parts, ...(own ? [own] : [])];
  }
  const nu = Number.isNaN(now.nu) ? "?" : angle(now.nu);
  return [...parts, ...(now.Z ? [] : [`r = ${brief(now.r)}`]), `ν = ${nu}`, `M = ${brief(now.M)}`];
}
