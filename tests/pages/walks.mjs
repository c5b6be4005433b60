// Looks at pages to walk through: walks.mjs FOLDER NAME... For each there are in FOLDER the page NAME.html and what `render`
// shows of the same: NAME-filmic.png; NAME-plain.png, one stop darker; NAME-dim.png, filmic and three stops darker;
// NAME-class.png, its classes; of the first also what its second camera sees, NAME-second.png. What the page shows goes there,
// too. The first page is walked through, and looked at with planted faults as well, which have to be refused: a check that
// cannot fail says nothing.
import { readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { layout } from "./checks.mjs";
import { launch } from "./launch.mjs";
import { addressOf, difference } from "./pictures.mjs";
import { WALK_FAULTS } from "./walk_faults.mjs";

// Levels of 255 by which a pixel may be off and still be the same.
const SAME = 4;
// How far what the page shows may be from what is rendered, in the mean: outlines, and interpolation over triangles.
const MOST_MEAN = { filmic: 1, plain: 1, dim: 0.5, class: 3, second: 1 };
// What is changed changes more than this, in the mean.
const CHANGED = 0.5;
const PHONE = { width: 390, height: 844 };

/** A page as someone sees it, and what it complains of. */
async function opened(browser, file, { width, height, scheme = "light" }) {
  const complaints = [];
  const page = await browser.newPage();
  page.on("console", message => complaints.push(`console, ${message.type()}: ${message.text()}`));
  page.on("pageerror", error => complaints.push(`script error: ${error.message}`));
  page.on("request", request => {
    const url = request.url();
    if (url !== pathToFileURL(file).href && !/^(data|blob):/.test(url)) complaints.push(`loads ${url}`);
  });
  const isPhone = width === PHONE.width;
  await page.setViewport({ width, height, isMobile: isPhone, hasTouch: isPhone });
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
  await page.goto(pathToFileURL(file).href, { waitUntil: "load" });
  const isThere = () => document.documentElement.dataset.ready !== undefined || /cannot/.test(document.getElementById("status").textContent);
  await page.waitForFunction(isThere, { timeout: 120_000 }).catch(() => complaints.push("nothing is there after two minutes"));
  const said = await page.$eval("#status", status => status.hidden ? "" : status.textContent);
  if (said) complaints.push(said);
  return { page, complaints };
}

/** What is seen without the controls, when nothing moves any more. */
async function picture(page) {
  const cover = isHidden => page.evaluate(isHidden => {
    for (const id of ["panel", "pad"]) document.getElementById(id).style.visibility = isHidden ? "hidden" : "";
    return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done))));
  }, isHidden);
  await page.evaluate(() => document.activeElement?.blur());
  await cover(true);
  const png = await page.screenshot();
  await cover(false);
  return png;
}

/**
 * What is wrong with the page as it looks and, if it is walked through, behaves; `told` gets the figures. It ends early once
 * there is a complaint of something `expected`.
 */
async function looked(browser, folder, name, file, { isWalked, expected, told = [] }) {
  const rendered = kind => readFile(join(folder, `${name}-${kind}.png`));
  const filmic = await rendered("filmic");
  const size = { width: filmic.readUInt32BE(16), height: filmic.readUInt32BE(20) };
  const { page, complaints } = await opened(browser, file, size);
  const blank = await browser.newPage();
  const apart = async (a, b) => blank.evaluate(difference, addressOf(a), addressOf(b), SAME);
  const compare = async kind => {
    const seen = await picture(page);
    await writeFile(join(folder, `${name}-${kind}-page.png`), seen);
    const { mean, share } = await apart(await rendered(kind), seen);
    told.push(`${kind} ${mean.toFixed(2)} (${(100 * share).toFixed(2)} % by more than ${SAME})`);
    if (mean > MOST_MEAN[kind]) complaints.push(`${kind}: differs from what is rendered by ${mean.toFixed(2)} levels in the mean`);
    return seen;
  };
  const changes = async (what, before, work) => {
    await work();
    const { mean } = await apart(before, await picture(page));
    if (mean < CHANGED) complaints.push(`${what}: the picture stays as it is`);
  };
  const goesBack = async (what, before, work) => {
    await work();
    const { most } = await apart(before, await picture(page));
    if (most > 0) complaints.push(`${what}: not what it was`);
  };
  const click = selector => page.$eval(selector, element => element.click());
  const press = async (key, milliseconds = 0) => {
    await page.keyboard.down(key);
    await new Promise(done => setTimeout(done, milliseconds));
    await page.keyboard.up(key);
  };

  const start = await compare("filmic");
  const show = isShown => page.$eval("#panel", (panel, isShown) => { panel.open = isShown; }, isShown);
  const expose = async (key, stops) => {
    await show(true);
    await page.focus("#stops");
    for (let quarter = 0; quarter < 4 * stops; quarter += 1) await page.keyboard.press(key);
  };
  const drag = async () => {
    await page.mouse.move(20, 100);
    await page.mouse.down();
    await page.mouse.move(80, 130, { steps: 3 });
    await page.mouse.up();
  };
  const away = async (what, work) => {
    await changes(what, start, work);
    await goesBack("back", start, () => press("r"));
  };
  const steps = [
    async () => {
      await expose("ArrowLeft", 1);
      await click("input[value=plain]");
      await compare("plain");
      await click("input[value=filmic]");
      await expose("ArrowLeft", 2);
      await compare("dim");
      await goesBack("exposure and tone", start, () => expose("ArrowRight", 3));
    },
    async () => {
      await click("#classes");
      await compare("class");
      if (await page.$eval("#legend", legend => legend.hidden || legend.querySelectorAll("li").length < 4)) complaints.push("no legend");
      await goesBack("class colours", start, () => press("c"));
    },
  ];
  const walk = [
    async () => {
      await changes("element mesh", start, () => click("#mesh"));
      await writeFile(join(folder, `${name}-mesh-page.png`), await picture(page));
      await goesBack("element mesh", start, () => press("m"));
    },
    async () => {
      await page.select("#camera", "1");
      await compare("second");
      await goesBack("first camera", start, () => press("1"));
    },
    async () => complaints.push(...await reachable(page)),
    async () => {
      await show(false);
      await away("orbit, dragged", drag);
    },
    () => away("orbit, a", () => press("a", 200)),
    () => away("the wheel", () => page.mouse.wheel({ deltaY: -400 })),
    () => press("f"),
    ...["w", "a", "ArrowDown", "j", "e"].map(key => () => away(`fly, ${key}`, () => press(key, 200))),
    () => away("fly, dragged", drag),
  ];
  for (const step of isWalked ? [...steps, ...walk] : steps) {
    if (!complaints.some(line => line.includes(expected))) await step();
  }
  await page.close();
  await blank.close();
  return complaints;
}

/** Whether everything can be reached by keyboard. */
async function reachable(page) {
  const isDead = () => page.$eval("#speed", slider => slider.disabled);
  const complaints = (await isDead()) ? [] : ["the speed can be set in orbit, where there is none"];
  await page.$eval("input[value=fly]", radio => radio.click());
  if (await isDead()) complaints.push("the speed cannot be set while flying");
  const reached = new Set();
  for (let i = 0; i < 25; i += 1) {
    await page.keyboard.press("Tab");
    reached.add(await page.evaluate(() => {
      const { id, name, tagName } = document.activeElement;
      return id || name || tagName.toLowerCase();
    }));
  }
  const wanted = ["view", "summary", "camera", "back", "move", "speed", "stops", "tone", "mesh", "classes"];
  complaints.push(...wanted.filter(id => !reached.has(id)).map(id => `not reached by keyboard: ${id}`));
  return complaints;
}

/** What is wrong with the page on a phone or in the dark; screenshots with the controls. */
async function laidOut(browser, folder, name, file, view) {
  const { page, complaints } = await opened(browser, file, view);
  const shot = `${name}-${view.width}-${view.scheme}`;
  const isPhone = view.width === PHONE.width;
  if (isPhone) {
    const turned = await opened(browser, file, { width: PHONE.height, height: PHONE.width });
    for (const [held, seen] of [["upright", page], ["sideways", turned.page]]) {
      if (await seen.$eval("#panel", panel => panel.open)) complaints.push(`controls cover the scene of a phone held ${held} at first`);
    }
    await turned.page.close();
    const start = await picture(page);
    const moved = async what => {
      if (Buffer.compare(start, await picture(page)) === 0) complaints.push(`phone, ${what}: the picture stays as it is`);
    };
    await page.touchscreen.touchStart(200, 500);
    await page.touchscreen.touchMove(260, 540);
    await page.touchscreen.touchEnd();
    await moved("dragged");
    await page.$eval("#back", button => button.click());
    await page.$eval("input[value=fly]", radio => radio.click());
    const pad = await page.$eval("#pad [data-key=KeyW]", button => {
      const { x, y, width, height } = button.getBoundingClientRect();
      return { x: x + width / 2, y: y + height / 2, size: Math.min(width, height) };
    });
    if (pad.size < 44) complaints.push(`buttons of ${pad.size} pixels are hard to hit`);
    await page.touchscreen.touchStart(pad.x, pad.y);
    await new Promise(done => setTimeout(done, 300));
    await page.touchscreen.touchEnd();
    await moved("a button held");
    for (const key of ["Enter", "Space"]) {
      await page.$eval("#back", button => button.click());
      await page.focus("#pad [data-key=KeyW]");
      await page.keyboard.down(key);
      await new Promise(done => setTimeout(done, 300));
      await page.keyboard.up(key);
      await moved(`${key} on a button`);
      const halted = await picture(page);
      await new Promise(done => setTimeout(done, 200));
      if (Buffer.compare(halted, await picture(page)) !== 0) complaints.push(`phone, ${key} on a button: it does not stop`);
    }
    await page.screenshot({ path: join(folder, `${shot}-closed.png`) });
  }
  await page.evaluate(() => {
    document.querySelectorAll("details").forEach(folded => { folded.open = true; });
    if (!document.getElementById("classes").checked) document.getElementById("classes").click();
  });
  const isOfPlots = line => /^no plots/.test(line);
  complaints.push(...(await page.evaluate(layout, view.width)).filter(line => !isOfPlots(line)));
  const box = await page.$eval("#panel", panel => {
    const { left, right, top, bottom } = panel.getBoundingClientRect();
    return { left, right, top, bottom, wide: panel.scrollWidth - panel.clientWidth };
  });
  if (box.left < 0 || box.right > view.width || box.top < 0 || box.bottom > view.height) complaints.push("controls reach out of the screen");
  if (box.wide > 0) complaints.push("controls are too wide for their frame");
  await page.screenshot({ path: join(folder, `${shot}.png`) });
  await page.close();
  return complaints;
}

const [folder, ...names] = process.argv.slice(2);
const browser = await launch();
let failed = 0;
const check = (name, complaints) => {
  complaints.forEach(line => console.log(`FAILED: ${name}: ${line}`));
  failed += complaints.length;
};
try {
  for (const [index, name] of names.entries()) {
    const file = join(folder, `${name}.html`);
    const told = [];
    check(name, await looked(browser, folder, name, file, { isWalked: index === 0, told }));
    console.log(`${name}, mean difference of 255: ${told.join(", ")}`);
    if (index > 0) continue;
    const views = [{ width: 1000, height: 700 }, PHONE].flatMap(size => ["light", "dark"].map(scheme => ({ ...size, scheme })));
    for (const view of views) check(`${name}, ${view.width}, ${view.scheme}`, await laidOut(browser, folder, name, file, view));
    const text = await readFile(file, "utf8");
    const planted = join(folder, `planted-${name}.html`);
    for (const { name: fault, plant, complaint, isOfLayout } of WALK_FAULTS) {
      await writeFile(planted, plant(text));
      const found = isOfLayout ? await laidOut(browser, folder, `planted-${name}`, planted, views[2])
        : await looked(browser, folder, name, planted, { isWalked: true, expected: complaint });
      if (plant(text) === text || !found.some(line => line.includes(complaint))) {
        check(`${name}, planted fault not noticed`, [`${fault}; found: ${found.slice(0, 3).join("; ")}`]);
      }
    }
    console.log(`${name}: ${WALK_FAULTS.length} planted faults looked for`);
  }
} finally {
  await browser.close();
}
process.exit(failed === 0 ? 0 : 1);
