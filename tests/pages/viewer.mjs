// What runs in the page that shows a model.

/**
 * Draws the model through its first camera and compares that with the picture, channel by channel: the mean and the largest
 * difference in levels of 255, and the share of pixels off by more than `same`. `fault` is one to plant.
 */
export async function show(here, same, fault) {
  const THREE = await import("three");
  const { GLTFLoader } = await import("three/addons/loaders/GLTFLoader.js");
  const picture = new Image();
  picture.src = `${here}picture.png`;
  await picture.decode();
  const { width, height } = picture;
  const pixels = drawn => {
    const canvas = new OffscreenCanvas(width, height);
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(drawn, 0, 0);
    return context.getImageData(0, 0, width, height).data;
  };

  const { scene, cameras } = await new GLTFLoader().loadAsync(`${here}model.glb`);
  scene.traverse(({ material }) => {
    if (material && fault === "sides") material.side = THREE.BackSide;
    if (material && fault === "light") material.color.setScalar(0.9);
  });
  const canvas = document.createElement("canvas");
  const renderer = new THREE.WebGLRenderer({ canvas, preserveDrawingBuffer: true });
  renderer.setSize(width, height, false);
  // As the picture does where there is nothing.
  renderer.setClearColor(0x000000, 1);
  scene.updateMatrixWorld();
  if (fault === "camera") cameras[0].fov *= 1.05;
  cameras[0].aspect = width / height;
  cameras[0].updateProjectionMatrix();
  renderer.render(scene, cameras[0]);

  const [ours, theirs] = [pixels(picture), pixels(canvas)];
  let [sum, most, off] = [0, 0, 0];
  for (let i = 0; i < ours.length; i += 4) {
    const difference = Math.max(...[0, 1, 2].map(c => Math.abs(ours[i + c] - theirs[i + c])));
    sum += difference;
    most = Math.max(most, difference);
    off += difference > same ? 1 : 0;
  }
  const count = width * height;
  return { url: canvas.toDataURL("image/png"), mean: sum / count, most, share: off / count };
}
