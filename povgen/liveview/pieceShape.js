// A piece's distance field, from the bytes in the page to the numbers in a 3D texture. povgen/rendering/volumes.py makes the
// bytes. objects.glsl finds the piece's surface in the texture.

// The bytes that Python's zlib has compressed and base64 has encoded.
async function inflated(text) {
  const raw = atob(text), packed = new Uint8Array(raw.length);
  for (let k = 0; k < raw.length; k++) packed[k] = raw.charCodeAt(k);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// The distances to the surface, in voxels, below 0 inside. The bytes hold distances up to `most`, each as the difference to the one
// before along z, and in the second half to that of the mirrored point. Farther away the field is extended.
export async function field({ data, most }, grid) {
  const bytes = await inflated(data), layer = grid[0] * grid[1], half = bytes.length / 2;
  const distances = Float32Array.from({ length: 256 }, (_, byte) => (byte === 255 ? Infinity : ((byte - 128) / 127) * most));
  const distance = new Float32Array(bytes.length);
  for (let k = 0; k < bytes.length; k++) {
    const z = Math.floor(k / layer);
    if (z) bytes[k] += bytes[k < half ? k - layer : k + (grid[2] - 1 - 2 * z) * layer];  // modulo 256
    distance[k] = distances[bytes[k]];
  }
  return extended(distance, grid, most);
}

// Where a distance is unknown: the least sum of a known distance and the way to it along the axes, divided by sqrt(3). It is
// about 0.6 to 1 times the distance.
function extended(distance, [nx, ny, nz], most) {
  const found = distance.slice(), { length } = found;
  for (const [stride, size] of [[1, nx], [nx, ny], [nx * ny, nz]]) {
    const line = stride * size;  // a point is the first or the last along this axis where k % line is in the first or the last stride
    for (let k = stride; k < length; k++) if (k % line >= stride) found[k] = Math.min(found[k], found[k - stride] + 1);
    for (let k = length - 1 - stride; k >= 0; k--) if (k % line < line - stride) found[k] = Math.min(found[k], found[k + stride] + 1);
  }
  return distance.map((known, k) => (known < most ? known : Math.max(found[k] / Math.sqrt(3), most)));
}
