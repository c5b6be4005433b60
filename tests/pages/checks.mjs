// What has to hold on every page, on every screen.

/** Runs within the page: widths, pictures, plots and whether their letters can be read, on a screen of this width. */
export function layout(width) {
  const found = [];
  const root = document.documentElement;
  // A phone shows a page that is too wide as a whole, so its own width tells nothing.
  if (root.scrollWidth > width) found.push(`the page is ${root.scrollWidth} wide on a screen of ${width}`);
  for (const name of ["viewport", "color-scheme"]) {
    if (!document.querySelector(`meta[name=${name}]`)) found.push(`no meta ${name}`);
  }
  for (const image of document.images) {
    if (!image.complete || image.naturalWidth === 0) found.push(`no picture: ${image.alt}`);
    if (!image.alt) found.push("a picture without words");
  }
  for (const button of document.querySelectorAll("button, summary")) {
    if (!(button.textContent.trim() || button.getAttribute("aria-label"))) found.push("something to press has no name");
  }

  // Contrast as WCAG 2.2 counts it: 4.5 for letters, 3 for what is drawn.
  const channels = colour => (colour.match(/[\d.]+/g) ?? []).map(Number);
  const luminance = colour => {
    const linear = channels(colour).slice(0, 3).map(c => c / 255).map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
  };
  const ground = element => {
    for (let at = element; at; at = at.parentElement) {
      const colour = getComputedStyle(at).backgroundColor;
      if (channels(colour).length === 3) return colour;
    }
    return "rgb(255, 255, 255)";
  };
  const contrast = (colour, element) => {
    const [dark, light] = [luminance(colour), luminance(ground(element))].sort((a, b) => a - b);
    return (light + 0.05) / (dark + 0.05);
  };
  for (const element of document.querySelectorAll("h1, h2, p, figcaption, caption, th, td, button, summary, li, code, label")) {
    const value = contrast(getComputedStyle(element).color, element);
    if (value < 4.5) found.push(`letters with a contrast of ${value.toFixed(1)}: ${element.textContent.slice(0, 40)}`);
  }

  // What the colours of a heat map stand for is beside them.
  for (const scale of document.querySelectorAll("ul.scale")) {
    const colours = [...scale.querySelectorAll(".swatch")].map(swatch => getComputedStyle(swatch).backgroundColor);
    if (colours.length < 4) found.push(`a heat map has ${colours.length} colours in its legend`);
    if (new Set(colours).size < colours.length) found.push("colours of a heat map look alike in its legend");
  }
  const maps = [...document.querySelectorAll("figure.picture:not(.wipe)")].filter(figure => figure.closest("section").querySelector("ul.scale"));
  const scales = document.querySelectorAll("ul.scale").length;
  if (maps.length !== scales) found.push(`${maps.length} heat maps have ${scales} legends`);

  const figures = [...document.querySelectorAll("figure.plot")];
  if (figures.length === 0) found.push("no plots");
  for (const figure of figures) {
    const name = figure.querySelector("figcaption").textContent;
    const seen = [...figure.querySelectorAll("svg")].filter(svg => svg.getBoundingClientRect().width > 200);
    if (seen.length !== 1) {
      found.push(`${seen.length} plots are seen instead of one: ${name}`);
      continue;
    }
    const marks = [...seen[0].querySelectorAll("rect, circle, polyline")];
    if (marks.length === 0) found.push(`nothing is drawn: ${name}`);
    // What is hollow has the colour of its outline. The ground of a plot is a rectangle too, in the colour of the page.
    const colourOf = mark => {
      const { fill, stroke } = getComputedStyle(mark);
      return fill === "none" ? stroke : fill;
    };
    const isColoured = mark => mark.tagName !== "polyline" && colourOf(mark) !== ground(figure);
    for (const mark of marks.filter(isColoured)) {
      const value = contrast(colourOf(mark), figure);
      if (value < 3) found.push(`a mark with a contrast of ${value.toFixed(1)}: ${name}`);
    }
    const looks = [...figure.querySelectorAll(".legend .swatch")].map(swatch => {
      const { color, backgroundColor } = getComputedStyle(swatch);
      return `${color} on ${backgroundColor}`;
    });
    const alike = looks.length - new Set(looks).size;
    if (alike > 0) found.push(`${alike} entries of the legend look like another one: ${name}`);
    const letters = [...seen[0].querySelectorAll("text")];
    if (letters.length === 0) found.push(`no letters: ${name}`);
    const frame = figure.closest("section").getBoundingClientRect();
    const boxes = letters.map(text => text.getBoundingClientRect());
    // A pixel more or less is the air around letters.
    const meet = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1
      && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 3;
    for (const [index, text] of letters.entries()) {
      const box = boxes[index];
      const words = `${text.textContent.trim()}, ${name}`;
      const other = boxes.slice(0, index).findIndex(before => meet(before, box));
      if (other >= 0) found.push(`letters over each other: ${letters[other].textContent.trim()} and ${words}`);
      // Turned letters are as high as their box is wide.
      const size = Math.min(box.width, box.height);
      if (text.textContent.trim().length > 2 && size < 12) found.push(`letters ${size.toFixed(1)} high: ${words}`);
      if (box.left < frame.left || box.right > frame.right) found.push(`letters outside: ${words}`);
      const value = contrast(getComputedStyle(text).fill, figure);
      if (value < 4.5) found.push(`letters with a contrast of ${value.toFixed(1)}: ${words}`);
    }
  }
  return found;
}

/** Presses every header twice and looks at the order of the rows. */
export async function sorting(page) {
  return page.evaluate(() => {
    const found = [];
    document.querySelectorAll("details").forEach(details => { details.open = true; });
    const tables = [...document.querySelectorAll("table.sorts")];
    if (tables.length === 0) found.push("no tables that sort");
    for (const table of tables) {
      const name = table.caption.textContent;
      const before = [...table.tBodies[0].rows];
      const foot = table.tFoot?.textContent;
      [...table.tHead.rows[0].cells].forEach((head, column) => {
        for (const order of ["ascending", "descending"]) {
          head.querySelector("button").click();
          if (head.getAttribute("aria-sort") !== order) found.push(`not sorted ${order}: ${name}, ${head.textContent}`);
          const cells = [...table.tBodies[0].rows].map(row => row.cells[column]);
          const numbers = cells.map(cell => cell.dataset.value).filter(value => value !== undefined).map(Number);
          const sign = order === "ascending" ? 1 : -1;
          const isSorted = numbers.every((number, i) => i === 0 || sign * (number - numbers[i - 1]) >= 0);
          if (!isSorted) found.push(`numbers out of order: ${name}, ${head.textContent}`);
          const words = cells.filter(cell => cell.dataset.value === undefined).map(cell => cell.textContent);
          const wanted = [...words].sort((a, b) => sign * a.localeCompare(b, "en", { numeric: true }));
          if (words.join("\n") !== wanted.join("\n")) found.push(`words out of order: ${name}, ${head.textContent}`);
        }
      });
      const after = [...table.tBodies[0].rows];
      if (after.length !== before.length || before.some(row => !after.includes(row))) found.push(`rows are lost: ${name}`);
      if (table.tFoot?.textContent !== foot) found.push(`the last row moved: ${name}`);
    }
    return found;
  });
}

/** Moves the slider by keyboard, and with the mouse on the picture, and looks at what is covered. */
export async function slider(page) {
  const found = [];
  const figures = await page.$$("figure.wipe");
  for (const figure of figures) {
    const input = await figure.$("input[type=range]");
    const frame = await figure.$(".frame");
    // Of the picture above, what is cut off at its right, pixels; and where the line stands.
    const state = () => figure.evaluate(element => {
      const frame = element.querySelector(".frame").getBoundingClientRect();
      const above = element.querySelector(".above");
      const cut = getComputedStyle(above).clipPath.match(/inset\(0px calc\(100% - (.*?)%\)|inset\(0px ([\d.]+)%/);
      const line = element.querySelector(".border").getBoundingClientRect();
      const below = element.querySelector(".below").getBoundingClientRect();
      const box = above.getBoundingClientRect();
      return {
        shown: cut ? (cut[1] === undefined ? 100 - Number(cut[2]) : Number(cut[1])) : NaN,
        line: 100 * (line.left + line.width / 2 - frame.left) / frame.width,
        apart: Math.max(Math.abs(box.left - below.left), Math.abs(box.width - below.width), Math.abs(box.height - below.height)),
      };
    });
    const expect = async (what, wanted) => {
      const { shown, line, apart } = await state();
      if (!(Math.abs(shown - wanted) < 1.5 && Math.abs(line - wanted) < 1.5)) {
        found.push(`slider, ${what}: ${shown} % are shown and the line stands at ${line.toFixed(1)} % instead of ${wanted} %`);
      }
      if (apart > 1) found.push(`slider, ${what}: the pictures do not cover each other`);
    };
    await input.scrollIntoView();
    await expect("at first", 50);
    await input.focus();
    await page.keyboard.press("ArrowRight");
    await expect("one key to the right", 51);
    await page.keyboard.press("Home");
    await expect("Home", 0);
    await page.keyboard.press("End");
    await expect("End", 100);
    const name = await input.evaluate(element => element.getAttribute("aria-label"));
    if (!name) found.push("the slider has no name");
    await frame.scrollIntoView();
    const box = await frame.boundingBox();
    await page.mouse.move(box.x + 0.8 * box.width, box.y + 0.5 * box.height);
    await page.mouse.down();
    await page.mouse.move(box.x + 0.25 * box.width, box.y + 0.5 * box.height, { steps: 4 });
    await page.mouse.up();
    await expect("dragged to a quarter", 25);
    await page.mouse.move(box.x + 0.9 * box.width, box.y + 0.5 * box.height);
    await expect("moved without a button", 25);
  }
  if ((await page.title()).includes(" and ") && figures.length === 0) found.push("no slider");
  return found;
}
