// Numbers and sentences, as the page prints them.

const SYMBOL = { alpha: "α", z1: "z₁", z2: "z₂" };
const NAME = { alpha: "Ray-rotation angle α", z1: "Distance z₁ behind the sheets", z2: "Distance z₂ of the eye" };

const raised = (n) => [...String(n)].map((digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit] ?? "⁻").join("");

// The text of toFixed, toPrecision or toExponential with typographic signs. A number that rounds to 0 has no sign.
function printed(text) {
  const [digits, power] = text.replace("-", "").split("e");
  const sign = text.startsWith("-") && Number(digits) ? "−" : "";
  return sign + digits + (power ? ` × 10${raised(Number(power))}` : "");
}

const fixed = (x, digits) => printed(Math.abs(x) < 1e5 ? x.toFixed(digits) : x.toExponential(2));
const size = (x) => (Number.isFinite(x) ? printed(x < 1e4 ? x.toPrecision(4) : x.toExponential(2)) : "∞");
const angle = (x) => (Number.isNaN(x) ? "undefined" : `${fixed(x / radians(1), 1)}°`);
const quantity = (name, x) => (name === "alpha" ? `${fixed(x, 1)}°` : `${size(x)} tiles`);
const brief = (name, x) => printed(String(x)) + (name === "alpha" ? "°" : "");

// A complex number. Both parts have the same number of decimals, so that the larger has five digits at most.
function point(a) {
  if (!finite(a)) return "∞";
  const decimals = Math.max(0, 3 - Math.floor(Math.log10(Math.max(1, Math.abs(a[0]), Math.abs(a[1])))));
  const [re, im] = a.map((x) => fixed(x, decimals));
  return `${re} ${im.startsWith("−") ? "−" : "+"} ${im.replace("−", "")} i`;
}

// ---- Sentences ----

function explanation(now) {
  if (!state.prediction) return "";
  const { thing, marked, sweep } = state.movie;
  if (!finite(now.P)) return "P is infinitely far away: no light from L reaches E.";
  const [nu, M] = appearanceText(now);
  const prisms = state.sheet === "detailed" ? ` Through these prisms: ν = ${nu}, M = ${M}.` : "";
  if (unsure(now)) return `Here the prediction is off by pixels: near the pole, or through large prisms.${prisms}`;
  const several = now.objects.length > 1;
  const what = several ? `Rings: predicted positions of the ${thing}s.` : `P: predicted position of the ${marked}.`;
  const others = `L and E: ${thing} and eye, projected.`;
  return `${what} Line: path of P as ${SYMBOL[sweep]} changes. ${others}${prisms}`;
}

function appearanceText(now) {
  const { nu, M } = appearance(now.z1, now.z2, now.alpha);
  return [angle(nu), size(M)];
}

function describe(now) {
  const { thing, prisms } = state.movie;
  const model = state.sheet === "ideal" ? "the infinitely fine sheet" : `two sheets of ${prisms} Dove prisms`;
  const where = `α = ${fixed(now.degrees, 1)}°, z₁ = ${size(now.z1)} and z₂ = ${size(now.z2)} tiles`;
  const [nu, M] = appearanceText(now);
  const how = finite(now.P)
    ? `It appears rotated by ν = ${nu} and M = ${M} times as large as in the plane of the sheets.`
    : "It is not seen, because P is infinitely far away.";
  return `A ${thing} seen through ${model}, with ${where}. ${how}`;
}
