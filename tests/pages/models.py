"""Looks at models that `export` writes: models.py LIGHTSHAFT FOLDER.

The validator of Khronos reads them, and three.js in a headless Chromium shows them through their own cameras, which has
to be what `render` shows through those of the scene. FOLDER gets the models and the pictures. Where what it needs
(browser.py) cannot be had, it says SKIPPED and why, with exit code 0; with LIGHTSHAFT_REQUIRE_BROWSER=1 that is a
failure.
"""

import pathlib
import sys

from browser import PROJECT, look, looked_at, run

EXPOSURE = {"cornell-box": "3", "paper-1": "1"}


def write_models(lightshaft, folder):
    """Model and picture of each scene, in turn."""
    written = []
    for name, exposure in EXPOSURE.items():
        scene = PROJECT / "scenes" / name / "scene.toml"
        solution, model, picture = (folder / f"{name}.{kind}" for kind in ("lsol", "glb", "png"))
        run([lightshaft, "solve", scene, "-o", solution, "--quality", "draft", "-q"], "lightshaft solve")
        run([lightshaft, "export", solution, "--glb", model, "--exposure", exposure, "-q"], "lightshaft export")
        shown = ["--exposure", exposure, "--tone", "plain", "--samples", "1", "--width", "480", "-q"]
        run([lightshaft, "render", scene, "--solution", solution, "-o", picture, *shown], "lightshaft render")
        written += [model, picture]
    return written


def main():
    lightshaft, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    looked_at("the models", lambda browser: look(browser, "models.mjs", [folder, *write_models(lightshaft, folder)]))


main()
