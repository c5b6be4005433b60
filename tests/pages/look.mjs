// Looks at pages in a headless Chromium: look.mjs FOLDER PAGE... Screenshots go to FOLDER. First it looks at copies
// with a planted fault each, which it has to refuse: a check that cannot fail says nothing. The pictures of a long page are
// numbered: beyond 8192 pixels the browser draws the top of a page once more.
import { readFile, writeFile } from "node:fs/promises";
import { basename, join } from "node:path";
import { pathToFileURL } from "node:url";
import { faultsOf } from "./faults.mjs";
import { layout, slider, sorting } from "./checks.mjs";
import { launch } from "./launch.mjs";

const PHONE = 390;
const PIECE = 4000;
const VIEWS = [1200, PHONE].flatMap(width => ["light", "dark"].map(scheme => ({ width, scheme })));

/** Screenshots of a whole page, one below the other, each of a height that the browser can draw. */
async function shoot(page, prefix) {
  const { width, height } = await page.evaluate(() => {
    const { clientWidth, scrollHeight } = document.documentElement;
    return { width: clientWidth, height: scrollHeight };
  });
  const view = page.viewport();
  await page.setViewport({ ...view, height: PIECE });
  for (let top = 0, number = 1; top < height; top += PIECE, number += 1) {
    // The last one ends where the page does, so it shows something of the one before.
    const from = await page.evaluate(y => { scrollTo(0, y); return scrollY; }, top);
    const clip = { x: 0, y: from, width, height: Math.min(PIECE, height - from) };
    await page.screenshot({ path: `${prefix}-${number}.png`, clip, captureBeyondViewport: false });
  }
  await page.setViewport(view);
}

/** Everything that is wrong with a page as it is seen here; takes a screenshot when it is told where. */
async function complaints(browser, file, { width, scheme }, screenshot) {
  const found = [];
  const page = await browser.newPage();
  page.on("console", message => found.push(`console, ${message.type()}: ${message.text()}`));
  page.on("pageerror", error => found.push(`script error: ${error.message}`));
  page.on("request", request => {
    const url = request.url();
    if (url !== pathToFileURL(file).href && !url.startsWith("data:")) found.push(`loads ${url}`);
  });
  const isPhone = width === PHONE;
  await page.setViewport({ width, height: 844, isMobile: isPhone, hasTouch: isPhone });
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
  await page.goto(pathToFileURL(file).href, { waitUntil: "load" });
  // What is folded away has to hold, too.
  await page.evaluate(() => document.querySelectorAll("details").forEach((folded) => { folded.open = true; }));
  found.push(...await page.evaluate(layout, width));
  if (screenshot) await shoot(page, screenshot);
  found.push(...await sorting(page), ...await slider(page));
  await page.close();
  return found;
}

const [folder, ...files] = process.argv.slice(2);
const browser = await launch();
let failed = 0;
try {
  console.log(await browser.version());
  for (const file of files) {
    const text = await readFile(file, "utf8");
    for (const { name, plant, complaint, view } of faultsOf(text)) {
      const planted = join(folder, `planted-${basename(file)}`);
      await writeFile(planted, plant(text));
      const found = await complaints(browser, planted, { ...VIEWS[0], ...view });
      if (plant(text) === text || !found.some(line => line.includes(complaint))) {
        console.log(`FAILED: ${basename(file)}, planted fault not noticed: ${name}; found: ${found.slice(0, 3).join("; ")}`);
        failed += 1;
      }
    }
    for (const view of VIEWS) {
      const name = `${basename(file, ".html")}-${view.width}-${view.scheme}`;
      const found = await complaints(browser, file, view, join(folder, name));
      found.forEach(line => console.log(`FAILED: ${name}: ${line}`));
      failed += found.length;
      if (found.length === 0) console.log(`${name}: as it should be`);
    }
  }
} finally {
  await browser.close();
}
process.exit(failed === 0 ? 0 : 1);
