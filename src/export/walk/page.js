// The page: the scene on the canvas, and the controls beside it.

const found = id => document.getElementById(id);

// As many pixels are drawn at most, whatever the screen has.
const MOST_PIXELS = 1 << 23;

/**
 * Pixels that are drawn for one of the page, along a line. Four for one of the screen where those are large: the samples that
 * the graphics card would take of a pixel have no depth of their own when the shader gives it, and dots of what lies behind
 * an edge would show along it.
 */
function sharpness(width, height) {
  const wanted = devicePixelRatio < 2 ? 2 * devicePixelRatio : Math.min(devicePixelRatio, 3);
  return Math.min(wanted, Math.max(1, Math.sqrt(MOST_PIXELS / Math.max(width * height, 1))));
}

async function show() {
  const settings = JSON.parse(found("settings").textContent);
  const canvas = found("view");
  if (!found("three-module")) throw new Error("the file is cut off");
  if (typeof DecompressionStream === "undefined") throw new Error("this browser is too old: it unpacks nothing by itself");
  const three = await library();
  const context = canvas.getContext("webgl2", { antialias: false, alpha: false, powerPreference: "high-performance" });
  if (!context) throw new Error("this browser has no WebGL 2, or it is switched off");
  const renderer = new three.WebGLRenderer({ canvas, context });
  renderer.setClearColor(0x000000, 1);

  const uniforms = {
    exposure: { value: 1 }, filmic: { value: true }, mesh: { value: false }, classes: { value: false },
    near: { value: 1 }, far: { value: 2 }, ratio: { value: 1 }, height: { value: 1 },
    colours: { value: settings.classes.map(colour => new three.Vector3(...colour.map(linearOf))) },
  };
  const material = new three.RawShaderMaterial({
    vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms, glslVersion: three.GLSL3, side: three.FrontSide,
  });
  const scene = new three.Scene();
  const bounds = new three.Box3();
  const counts = { vertices: 0, triangles: 0 };
  for (const script of document.querySelectorAll("script.part")) {
    const { positions, light, corners } = await part(script);
    const geometry = new three.BufferGeometry();
    geometry.setAttribute("position", new three.BufferAttribute(positions, 3));
    geometry.setAttribute("light", new three.Float16BufferAttribute(light, 4));
    geometry.setIndex(new three.BufferAttribute(corners, 1));
    geometry.computeBoundingBox();
    geometry.computeBoundingSphere();
    bounds.union(geometry.boundingBox);
    counts.vertices += positions.length / 3;
    counts.triangles += corners.length / 3;
    // What the graphics card has is not kept here, too.
    for (const attribute of [geometry.index, ...Object.values(geometry.attributes)]) {
      attribute.onUpload(() => { attribute.array = null; });
    }
    scene.add(new three.Mesh(geometry, material));
  }

  const camera = new three.PerspectiveCamera();
  const walker = new Walker(three, bounds.getSize(new three.Vector3()).length());
  let lens = settings.cameras[0];

  const draw = () => {
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    // There is nothing to see, as in a frame that is folded away.
    if (width === 0 || height === 0) return;
    const ratio = sharpness(width, height);
    if (renderer.getPixelRatio() !== ratio) renderer.setPixelRatio(ratio);
    const size = renderer.getSize(new three.Vector2());
    if (size.x !== width || size.y !== height) renderer.setSize(width, height, false);
    walker.aim(camera);
    // All that the camera of the scene sees is in the picture, however narrow that is.
    const half = Math.tan(lens.vfov * Math.PI / 360) * Math.max(1, lens.aspect * height / width);
    camera.fov = Math.min(Math.atan(half) * 360 / Math.PI, Math.max(lens.vfov, 120));
    camera.aspect = width / height;
    camera.far = 2 * (walker.size + bounds.distanceToPoint(walker.eye));
    camera.near = 1e-6 * camera.far;
    camera.updateProjectionMatrix();
    uniforms.near.value = camera.near;
    uniforms.far.value = camera.far;
    uniforms.ratio.value = ratio;
    uniforms.height.value = canvas.height;
    renderer.render(scene, camera);
  };
  // Drawn when something has changed, and as long as a key is held.
  let [isAsked, last] = [false, 0];
  const ask = () => {
    if (!isAsked) requestAnimationFrame(frame);
    isAsked = true;
  };
  const frame = now => {
    isAsked = false;
    // The first frame after a rest lasts as long as any.
    const isWalking = walker.walk(last ? Math.min(now - last, 100) / 1000 : 1 / 60);
    last = isWalking ? now : 0;
    draw();
    if (isWalking) ask();
  };

  const goTo = index => {
    if (!settings.cameras[index]) return;
    found("camera").value = index;
    lens = settings.cameras[index];
    walker.goTo(lens);
    ask();
  };
  const expose = stops => {
    found("stops").value = stops;
    const value = Number(found("stops").value);
    uniforms.exposure.value = 2 ** value;
    const multiplier = Number((settings.exposure * 2 ** value).toPrecision(3));
    found("exposure").textContent = `${value > 0 ? "+" : ""}${value} · × ${multiplier}`;
    found("stops").setAttribute("aria-valuetext", `${value} stops`);
    ask();
  };
  const choose = (name, value) => {
    document.querySelector(`input[name=${name}][value=${value}]`).checked = true;
    if (name === "tone") uniforms.filmic.value = value === "filmic";
    if (name === "move") {
      walker.isFlying = value === "fly";
      // In orbit there is no speed: turns are turns.
      found("speed").disabled = !walker.isFlying;
      // Keys are for those who have some.
      found("pad").hidden = !(walker.isFlying && matchMedia("(pointer: coarse)").matches);
    }
    ask();
  };
  const tick = (name, isOn) => {
    found(name).checked = isOn;
    uniforms[name].value = isOn;
    found("legend").hidden = !uniforms.classes.value;
    ask();
  };

  found("camera").addEventListener("change", event => goTo(event.target.value));
  found("back").addEventListener("click", () => goTo(found("camera").value));
  found("stops").addEventListener("input", event => expose(event.target.value));
  found("speed").addEventListener("input", event => {
    walker.speed = 2 ** event.target.value;
    found("pace").textContent = `× ${Number(walker.speed.toPrecision(2))}`;
  });
  for (const radio of document.querySelectorAll("input[type=radio]")) {
    radio.addEventListener("change", () => choose(radio.name, radio.value));
  }
  for (const name of ["mesh", "classes"]) found(name).addEventListener("change", event => tick(name, event.target.checked));

  followPointers(canvas, walker, ask);
  for (const button of found("pad").querySelectorAll("button")) {
    const hold = event => {
      event.preventDefault();
      walker.held.add(button.dataset.key);
      ask();
    };
    button.addEventListener("pointerdown", hold);
    for (const name of ["pointerup", "pointerleave", "pointercancel"]) {
      button.addEventListener(name, () => walker.held.delete(button.dataset.key));
    }
    button.addEventListener("contextmenu", event => event.preventDefault());
    button.addEventListener("keydown", event => {
      if (["Enter", "Space"].includes(event.code)) hold(event);
    });
    for (const name of ["keyup", "blur"]) {
      button.addEventListener(name, () => walker.held.delete(button.dataset.key));
    }
  }
  const shortcuts = {
    KeyO: () => choose("move", "orbit"), KeyF: () => choose("move", "fly"), KeyR: () => goTo(found("camera").value),
    KeyM: () => tick("mesh", !uniforms.mesh.value), KeyC: () => tick("classes", !uniforms.classes.value),
  };
  addEventListener("keydown", event => {
    walker.isHurried = event.shiftKey;
    // Those of the browser, and of what is being used.
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest?.("select")) return;
    const isRange = event.target.closest?.("input[type=range], input[type=radio], pre");
    if (event.code in MOVES && !(isRange && event.code.startsWith("Arrow"))) {
      walker.held.add(event.code);
      event.preventDefault();
      ask();
    } else if (event.code in shortcuts) {
      shortcuts[event.code]();
    } else if (/^[1-9]$/.test(event.key)) {
      goTo(Number(event.key) - 1);
    } else if (["+", "=", "-"].includes(event.key)) {
      expose(Number(found("stops").value) + (event.key === "-" ? -0.25 : 0.25));
    }
  });
  addEventListener("keyup", event => {
    walker.isHurried = event.shiftKey;
    walker.held.delete(event.code);
  });
  addEventListener("blur", () => walker.held.clear());
  addEventListener("resize", ask);
  canvas.addEventListener("webglcontextlost", () => tell("The graphics card has lost the picture; load the page again."));

  // On a phone, however it is held, they would cover the scene.
  if (innerWidth <= 640 || innerHeight <= 480) found("panel").open = false;
  found("counts").textContent = `${counts.triangles} triangles with ${counts.vertices} corners`;
  found("release").textContent = `, release ${three.REVISION}`;
  goTo(0);
  expose(0);
  choose("tone", settings.tone);
  choose("move", "orbit");
  tick("mesh", false);
  tick("classes", false);
  draw();
  found("status").hidden = true;
  document.documentElement.dataset.ready = "";
}

function tell(what) {
  found("status").textContent = what;
  found("status").hidden = false;
}

show().catch(error => tell(`The scene cannot be shown: ${error.message}.`));
