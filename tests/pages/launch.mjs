// Starts a headless Chromium.
import { writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import chromium, { inflate, setupLambdaEnvironment } from "@sparticuz/chromium";
import puppeteer from "puppeteer-core";

const DOES_NOT_START = 3;
// Drawing in three dimensions, without a graphics card.
const GRAPHICS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];

/** The browser, with the libraries and the fonts that come with it. */
async function started() {
  const bin = join(dirname(fileURLToPath(import.meta.url)), "node_modules/@sparticuz/chromium/bin");
  await inflate(join(bin, "al2023.tar.br"));
  setupLambdaEnvironment(join(tmpdir(), "al2023", "lib"));
  // In a container there may be no user to fall back to; only our own files are opened.
  const args = ["--no-sandbox", "--disable-dev-shm-usage", ...GRAPHICS];
  const executablePath = await chromium.executablePath();
  // Its own list of fonts names places that need not be there.
  const fonts = join(tmpdir(), "fonts");
  const places = `<dir>${join(fonts, "fonts")}</dir><cachedir>${join(fonts, "cache")}</cachedir>`;
  await writeFile(join(fonts, "fonts.conf"), `<?xml version="1.0"?><fontconfig>${places}</fontconfig>`);
  process.env.FONTCONFIG_PATH = fonts;
  return puppeteer.launch({ args, executablePath, headless: "shell", timeout: 120_000 });
}

/** The browser; where it does not start, the process ends with an exit code that says so. */
export function launch() {
  return started().catch(error => {
    console.log(error.message);
    process.exit(DOES_NOT_START);
  });
}
