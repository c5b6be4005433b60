// Looks at models: models.mjs FOLDER MODEL.glb PICTURE.png... What three.js shows of each goes to FOLDER. Everything is
// done to copies with a planted fault, too, which have to be refused: a check that cannot fail says nothing.
import { readFile, writeFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { basename, dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { launch } from "./launch.mjs";
import { addressOf, difference } from "./pictures.mjs";
import { show } from "./viewer.mjs";

const validator = createRequire(import.meta.url)("gltf-validator");
const PACKAGES = join(dirname(fileURLToPath(import.meta.url)), "node_modules");
// A host that is none: all that the page asks for is answered here.
const HERE = "http://models.invalid/";
const PAGE = `<!doctype html><title>model</title><script type="importmap">{"imports": {
  "three": "${HERE}three/build/three.module.js", "three/addons/": "${HERE}three/examples/jsm/"}}</script>`;
const TYPES = { js: "text/javascript", glb: "model/gltf-binary", png: "image/png" };

// Levels of 255 by which a channel of a pixel may be off and still be the same: dither, rounding, and interpolation over
// the triangles of an element instead of the element.
const SAME = 4;
// Share of pixels that may be off by more, along outlines, where a pixel is on one or the other surface; and the mean.
const MOST_OFF = 0.01;
const MOST_MEAN = 1;

/** Everything that the validator of Khronos has to say, but for hints. */
async function invalid(bytes) {
  const report = await validator.validateBytes(new Uint8Array(bytes), { maxIssues: 20 });
  const names = ["error", "warning"];
  const told = report.issues.messages.filter(({ severity }) => severity < names.length);
  return told.map(({ severity, code, message, pointer }) => `${names[severity]} ${code}: ${message} (${pointer})`);
}

/** A copy whose JSON was changed; it must not get longer. */
function changed(bytes, change) {
  const copy = Buffer.from(bytes);
  const length = copy.readUInt32LE(12);
  const text = copy.toString("utf8", 20, 20 + length);
  const other = change(text);
  if (other === text || Buffer.byteLength(other) > length) throw new Error("the planted fault did not fit");
  copy.fill(" ", 20, 20 + length);
  copy.write(other, 20, "utf8");
  return copy;
}

/** What three.js shows of a model through its first camera, and how far that is from a picture. */
async function shown(browser, model, picture, fault) {
  const page = await browser.newPage();
  const complaints = [];
  page.on("pageerror", error => complaints.push(`script error: ${error.message}`));
  page.on("console", message => {
    if (message.type() === "error") complaints.push(`console: ${message.text()}`);
  });
  await page.setRequestInterception(true);
  page.on("request", async request => {
    const path = request.url().slice(HERE.length);
    const answers = { "": PAGE, "model.glb": model, "picture.png": picture };
    const body = request.url().startsWith(HERE) && (answers[path] ?? await readFile(join(PACKAGES, path)).catch(() => null));
    if (!body) return request.respond({ status: 404, body: "" });
    return request.respond({ body, contentType: TYPES[path.split(".").pop()] ?? "text/html" });
  });
  await page.goto(HERE, { waitUntil: "load" });
  const url = await page.evaluate(show, HERE, fault ?? null);
  const { mean, most, share } = await page.evaluate(difference, addressOf(picture), url, SAME);
  await page.close();
  if (mean > MOST_MEAN) complaints.push(`differs by ${mean.toFixed(2)} levels in the mean`);
  if (share > MOST_OFF) complaints.push(`${(100 * share).toFixed(2)} % of the pixels differ`);
  const told = `mean difference ${mean.toFixed(3)} of 255, ${(100 * share).toFixed(3)} % of the pixels by more than ${SAME}, at most ${most}`;
  return { complaints, told, png: Buffer.from(url.split(",")[1], "base64") };
}

const [folder, ...files] = process.argv.slice(2);
const browser = await launch();
let failed = 0;
const check = (name, complaints) => {
  complaints.forEach(line => console.log(`FAILED: ${name}: ${line}`));
  failed += complaints.length;
};
const refuse = (name, complaints) => check(name, complaints.length > 0 ? [] : ["planted fault not noticed"]);
try {
  console.log(`${await browser.version()}, glTF validator ${validator.version()}`);
  for (let i = 0; i < files.length; i += 2) {
    const name = basename(files[i], ".glb");
    const [model, picture] = await Promise.all([readFile(files[i]), readFile(files[i + 1])]);
    check(`${name}, validator`, await invalid(model));
    const { complaints, told, png } = await shown(browser, model, picture);
    await writeFile(join(folder, `${name}-three.png`), png);
    console.log(`${name}: ${told}`);
    check(`${name}, three.js`, complaints);

    refuse(`${name}, bounds`, await invalid(changed(model, text => text.replace(/"max":\[[^\]]*\]/, '"max":[0,0,0]'))));
    refuse(`${name}, cut off`, await invalid(model.subarray(0, model.length - 4)));
    for (const fault of ["sides", "light", "camera"]) {
      refuse(`${name}, ${fault}`, (await shown(browser, model, picture, fault)).complaints);
    }
  }
} finally {
  await browser.close();
}
process.exit(failed === 0 ? 0 : 1);
