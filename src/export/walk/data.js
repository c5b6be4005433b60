// What is packed in the page, unpacked.

/** The bytes of a script that holds some. It is emptied: there is no use in holding them twice. */
async function unpacked(script) {
  const text = atob(script.textContent);
  script.remove();
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i += 1) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The library as a module. */
async function library() {
  const text = async id => new TextDecoder().decode(await unpacked(document.getElementById(id)));
  const address = code => URL.createObjectURL(new Blob([code], { type: "text/javascript" }));
  const core = address(await text("three-core"));
  const module = address((await text("three-module")).replaceAll("./three.core.js", core));
  const three = await import(module);
  [core, module].forEach(URL.revokeObjectURL);
  return three;
}

/** A part: positions, light with the mark of the vertex, and the corners of triangles. */
async function part(script) {
  const [vertices, triangles] = [Number(script.dataset.vertices), Number(script.dataset.triangles)];
  const bytes = await unpacked(script);
  if (bytes.length !== 20 * vertices + 6 * triangles) throw new Error("the file is damaged");
  let at = 0;
  // Values of `size` bytes, each the difference from the one before, to every `stride`th place.
  const read = (to, offset, stride, count, size) => {
    let value = 0;
    for (let i = 0; i < count; i += 1) {
      for (let plane = 0; plane < size; plane += 1) value += bytes[at + plane * count + i] * 2 ** (8 * plane);
      // Those arrays keep the lower bits.
      to[offset + i * stride] = value;
      value = to[offset + i * stride];
    }
    at += count * size;
  };
  const positions = new Uint32Array(3 * vertices);
  const light = new Uint16Array(4 * vertices);
  const corners = new Uint16Array(3 * triangles);
  for (let axis = 0; axis < 3; axis += 1) read(positions, axis, 3, vertices, 4);
  for (let channel = 0; channel < 4; channel += 1) read(light, channel, 4, vertices, 2);
  read(corners, 0, 1, 3 * triangles, 2);
  return { positions: new Float32Array(positions.buffer), light, corners };
}
