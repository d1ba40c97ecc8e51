// A QR code (ISO/IEC 18004) of a text: bytes, error correction of level L, mask 0.

const CHECKS = [7, 10, 15, 20, 26, 18, 20, 24, 30, 18, 20, 24, 26, 30, 22, 24, 28, 30, 28, 28];  // check bytes of a block, by version
const BLOCKS = [1, 1, 1, 1, 1, 2, 2, 2, 2, 4, 4, 4, 4, 4, 6, 6, 6, 6, 7, 8];
const LEVEL_AND_MASK = 0b01000;

// Products in the field of 256 elements with the polynomial x^8 + x^4 + x^3 + x^2 + 1.
function product(a, b) {
  let found = 0;
  for (let k = 7; k >= 0; k--) found = (found << 1) ^ ((found >> 7) * 0x11d) ^ (((b >> k) & 1) * a);
  return found;
}

// The check bytes of a block: the remainder by the product of (x - 2^k).
function checks(bytes, count) {
  const divisor = Array(count).fill(0);
  divisor[count - 1] = 1;
  for (let k = 0, root = 1; k < count; k++, root = product(root, 2)) {
    for (let n = 0; n < count; n++) divisor[n] = product(divisor[n], root) ^ (divisor[n + 1] ?? 0);
  }
  const rest = Array(count).fill(0);
  for (const byte of bytes) {
    const factor = byte ^ rest.shift();
    rest.push(0);
    divisor.forEach((each, n) => (rest[n] ^= product(each, factor)));
  }
  return rest;
}

const digits = (value, count) => value.toString(2).padStart(count, "0");

// A number with the remainder of its polynomial: the format and the version are written with one.
function withRemainder(value, polynomial, bits) {
  let rest = value << bits;
  for (let k = 31 - Math.clz32(rest); k >= bits; k--) if ((rest >> k) & 1) rest ^= polynomial << (k - bits);
  return (value << bits) | rest;
}

// The centres of the alignment patterns.
function centres(version, side) {
  if (version === 1) return [];
  const count = Math.floor(version / 7) + 2, step = Math.ceil((version * 4 + 4) / (count * 2 - 2)) * 2;
  return [6, ...Array.from({ length: count - 1 }, (_, k) => side - 7 - (count - 2 - k) * step)];
}

// All bytes of the data, with their check bytes, in the order in which they are drawn.
function interleaved(data, version, all) {
  const count = BLOCKS[version - 1], check = CHECKS[version - 1], short = Math.floor(all / count), long = all % count;
  const blocks = [];
  for (let k = 0, from = 0; k < count; k++) {
    const length = short - check + (k < count - long ? 0 : 1), bytes = data.slice(from, from + length);
    blocks.push([bytes, checks(bytes, check)]);
    from += length;
  }
  const columns = (part) => Array.from({ length: Math.max(...blocks.map((block) => block[part].length)) }, (_, n) => blocks.map((block) => block[part][n]));
  return [0, 1].flatMap((part) => columns(part).flat()).filter((byte) => byte !== undefined);
}

// The modules, row by row: true is dark. null if the text is too long.
export function qr(text) {
  const bytes = [...new TextEncoder().encode(text)];
  for (let version = 1; version <= CHECKS.length; version++) {
    const side = 17 + 4 * version, dark = Array.from({ length: side }, () => Array(side).fill(null));
    const set = (x, y, on) => dark[y]?.[x] !== undefined && (dark[y][x] = on);
    for (const [x, y] of [[3, 3], [side - 4, 3], [3, side - 4]]) {  // the finder patterns
      for (let u = -4; u <= 4; u++) for (let v = -4; v <= 4; v++) set(x + u, y + v, ![2, 4].includes(Math.max(Math.abs(u), Math.abs(v))));
    }
    const at = centres(version, side);
    at.forEach((x, j) => at.forEach((y, k) => {
      const corner = (j === 0 && k === 0) || (j === 0 && k === at.length - 1) || (j === at.length - 1 && k === 0);
      for (let u = -2; u <= 2 && !corner; u++) for (let v = -2; v <= 2; v++) set(x + u, y + v, Math.max(Math.abs(u), Math.abs(v)) !== 1);
    }));
    for (let k = 8; k < side - 8; k++) {  // the timing patterns
      set(k, 6, k % 2 === 0);
      set(6, k, k % 2 === 0);
    }
    const format = withRemainder(LEVEL_AND_MASK, 0x537, 10) ^ 0x5412, bit = (value, k) => Boolean((value >> k) & 1);
    for (let k = 0; k < 15; k++) {
      const [x, y] = k < 8 ? [8, k < 6 ? k : k + 1] : [k < 9 ? 15 - k : 14 - k, 8];
      set(x, y, bit(format, k));
      set(...(k < 8 ? [side - 1 - k, 8] : [8, side - 15 + k]), bit(format, k));
    }
    set(8, side - 8, true);
    for (let k = 0; version >= 7 && k < 18; k++) {
      const on = bit(withRemainder(version, 0x1f25, 12), k), [a, b] = [side - 11 + (k % 3), Math.floor(k / 3)];
      set(a, b, on);
      set(b, a, on);
    }
    const free = dark.flat().filter((module) => module === null).length >> 3;
    const room = free - BLOCKS[version - 1] * CHECKS[version - 1], lengthBits = version < 10 ? 8 : 16;
    if (12 + lengthBits + 8 * bytes.length > 8 * room + 8) continue;
    const bits = `0100${digits(bytes.length, lengthBits)}${bytes.map((byte) => digits(byte, 8)).join("")}0000`.slice(0, 8 * room);
    const data = bits.match(/.{1,8}/g).map((byte) => parseInt(byte.padEnd(8, "0"), 2));
    for (let k = 0; data.length < room; k++) data.push(k % 2 ? 0x11 : 0xec);
    const stream = [...interleaved(data, version, free).map((byte) => digits(byte, 8)).join("")];
    for (let right = side - 1; right > 0; right -= 2) {
      if (right === 6) right = 5;
      for (let k = 0; k < side; k++) {
        for (const x of [right, right - 1]) {
          const y = ((right + 1) & 2) === 0 ? side - 1 - k : k;
          if (dark[y][x] === null) dark[y][x] = (stream.shift() === "1") !== ((x + y) % 2 === 0);
        }
      }
    }
    return dark;
  }
  return null;
}
