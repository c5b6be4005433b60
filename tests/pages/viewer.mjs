// What runs in the page that shows a model.

/** Draws the model through its first camera in the size of the picture; the address of what it shows. `fault` is one to plant. */
export async function show(here, fault) {
  const THREE = await import("three");
  const { GLTFLoader } = await import("three/addons/loaders/GLTFLoader.js");
  const picture = new Image();
  picture.src = `${here}picture.png`;
  await picture.decode();
  const { width, height } = picture;

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
  return canvas.toDataURL("image/png");
}
