// A piece's distance field, from the bytes in the page to the numbers in a 3D texture. povgen/rendering/volumes.py makes the
// bytes. objects.glsl finds the piece's surface in the texture.

// The bytes that Python's zlib has compressed and base64 has encoded.
async function inflated(text) {
  const raw = atob(text), packed = new Uint8Array(raw.length);
  for (let k = 0; k < raw.length; k++) packed[k] = raw.charCodeAt(k);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// The distances to the surface, in voxels, below 0 inside. The bytes hold distances up to `most`, each as the difference
// to the one before along z. Farther away the field is extended: there it is about 0.9 to 1.05 times the distance.
export async function field({ data, most }, [nx, ny, nz]) {
  const bytes = await inflated(data);
  const distances = Float32Array.from({ length: 256 }, (_, byte) => (byte === 255 ? Infinity : ((byte - 128) / 127) * most));
  const distance = new Float32Array(bytes.length);
  for (let k = 0; k < bytes.length; k++) {
    if (k >= nx * ny) bytes[k] += bytes[k - nx * ny];  // modulo 256
    distance[k] = distances[bytes[k]];
  }
  extend(distance, nx, ny, nz, most);
  return distance;
}

// Two sweeps. An unknown distance is found from those of the neighbours that the sweep has passed, each plus a step. The
// sum of the steps can exceed the distance by 13 %, so each step is multiplied by 0.9.
function extend(distance, nx, ny, nz, most) {
  // Inside a border of voxels that are infinitely far away, each voxel has all neighbours.
  const width = nx + 2, layer = width * (ny + 2);
  const all = new Float32Array(layer * (nz + 2)).fill(Infinity);
  const rows = Array.from({ length: ny * nz }, (_, row) => 1 + width * (1 + (row % ny)) + layer * (1 + Math.floor(row / ny)));
  rows.forEach((start, n) => all.set(distance.subarray(nx * n, nx * (n + 1)), start));
  for (const sense of [1, -1]) {
    const [x, y, z] = [sense, sense * width, sense * layer];
    for (const start of sense > 0 ? rows : rows.toReversed()) {
      for (let n = 0; n < nx; n++) {
        const k = start + (sense > 0 ? n : nx - 1 - n);
        if (all[k] < most) continue;
        const face = Math.min(all[k - x], all[k - y], all[k - z]);
        const edge = Math.min(all[k - y - x], all[k - y + x], all[k - z - x], all[k - z + x], all[k - z - y], all[k - z + y]);
        const corner = Math.min(all[k - z - y - x], all[k - z - y + x], all[k - z + y - x], all[k - z + y + x]);
        all[k] = Math.min(all[k], Math.max(face, 0) + 0.9, Math.max(edge, 0) + 0.9 * Math.SQRT2, Math.max(corner, 0) + 0.9 * Math.sqrt(3));
      }
    }
  }
  rows.forEach((start, n) => distance.set(all.subarray(start, start + nx), nx * n));
}
