// How far two pictures are from each other.

/**
 * Runs within a page: of two pictures of one size, given by their addresses, the mean and the largest difference of a
 * pixel, that of its channel that differs most, in levels of 255, and the share of pixels off by more than `same`.
 */
export async function difference(first, second, same) {
  const pixels = async address => {
    const image = new Image();
    image.src = address;
    await image.decode();
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    return context.getImageData(0, 0, image.width, image.height).data;
  };
  const [ours, theirs] = [await pixels(first), await pixels(second)];
  if (ours.length !== theirs.length) return { mean: 255, most: 255, share: 1 };
  let [sum, most, off] = [0, 0, 0];
  for (let i = 0; i < ours.length; i += 4) {
    const difference = Math.max(...[0, 1, 2].map(c => Math.abs(ours[i + c] - theirs[i + c])));
    sum += difference;
    most = Math.max(most, difference);
    off += difference > same ? 1 : 0;
  }
  const count = ours.length / 4;
  return { mean: sum / count, most, share: off / count };
}

/** The address of a picture with these bytes. */
export const addressOf = png => `data:image/png;base64,${Buffer.from(png).toString("base64")}`;
