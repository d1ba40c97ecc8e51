// Texts in an address that nobody reads at a glance. They are no secret: everybody can undo this.

/** A number that a text gives: another text hardly gives the same one (FNV-1a).
 * @type {(bytes: Uint8Array) => number} */
const sumOf = (bytes) => bytes.reduce((sum, byte) => Math.imul(sum ^ byte, 0x01000193), 0x811c9dc5) >>> 0;
export const checksum = (text) => sumOf(new TextEncoder().encode(text));

// Bytes, each mixed with one of a sequence that begins with `seed`. The same again undoes it.
function mixed(bytes, seed) {
  let x = seed | 1;
  return bytes.map((byte) => {
    x ^= x << 13;
    x ^= x >>> 17;
    x ^= x << 5;
    return byte ^ (x & 255);
  });
}

// The checksum's four bytes, then those of the text, in letters, digits, - and _.
export function scrambled(text) {
  const bytes = new TextEncoder().encode(text), sum = sumOf(bytes);
  const all = [...[24, 16, 8, 0].map((shift) => (sum >>> shift) & 255), ...mixed(bytes, sum)];
  return btoa(all.map((byte) => String.fromCharCode(byte)).join("")).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

// Throws an error if the code is not complete.
export function unscrambled(code) {
  const all = Uint8Array.from(atob(code.replaceAll("-", "+").replaceAll("_", "/")), (letter) => letter.charCodeAt(0));
  const sum = new DataView(all.buffer).getUint32(0), bytes = mixed(all.slice(4), sum);
  if (sumOf(bytes) !== sum) throw new Error("cut");
  return new TextDecoder().decode(bytes);
}
