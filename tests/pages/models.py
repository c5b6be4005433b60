"""Looks at models and pages that `export` writes: models.py LIGHTSHAFT FOLDER.

The validator of Khronos reads them, and three.js in a headless Chromium shows them through their own cameras, which has
to be what `render` shows through those of the scene. The pages are walked
through in the same browser, and what they show has to be what `render` does, too. FOLDER gets all of it. Where what it needs
(browser.py) cannot be had, it says SKIPPED and why, with exit code 0; with LIGHTSHAFT_REQUIRE_BROWSER=1 that is a
failure.
"""

import pathlib
import sys

from browser import PROJECT, look, looked_at, run

EXPOSURE = {"cornell-box": "3", "paper-1": "1"}
# The first has elements for display besides those of its links: they are what is shown.
SOLVE = {"cornell-box": ["--local-pass"], "paper-1": [], "penumbra": []}
# The first has two cameras, and in the last one z is up. All are so bright that much of the light is more than white.
WALKS = {"paper-1": 4, "cornell-box": 6, "penumbra": 2}


def write_models(lightshaft, folder):
    """Model and picture of each scene, in turn."""
    written = []
    for name, exposure in EXPOSURE.items():
        scene = PROJECT / "scenes" / name / "scene.toml"
        solution, model, picture = (folder / f"{name}.{kind}" for kind in ("lsol", "glb", "png"))
        run([lightshaft, "solve", scene, "-o", solution, "--quality", "draft", "-q", *SOLVE[name]], "lightshaft solve")
        run([lightshaft, "export", solution, "--glb", model, "--exposure", exposure, "-q"], "lightshaft export")
        shown = ["--exposure", exposure, "--tone", "plain", "--samples", "1", "--width", "480", "-q"]
        run([lightshaft, "render", scene, "--solution", solution, "-o", picture, *shown], "lightshaft render")
        written += [model, picture]
    return written


def write_walks(lightshaft, folder):
    """The pages, and the pictures that they are compared with."""
    for name, exposure in WALKS.items():
        scene = PROJECT / "scenes" / name / "scene.toml"
        solution, page = (folder / f"{name}.{kind}" for kind in ("lsol", "html"))
        run([lightshaft, "solve", scene, "-o", solution, "--quality", "draft", "-q", *SOLVE[name]], "lightshaft solve")
        run([lightshaft, "export", solution, "--html", page, "--exposure", str(exposure), "-q"], "lightshaft export")
        kinds = {
            "filmic": ["--exposure", str(exposure)],
            "plain": ["--exposure", str(exposure / 2), "--tone", "plain"],
            "dim": ["--exposure", str(exposure / 8)],
            "class": ["--view", "class"],
        }
        if name == "paper-1":
            kinds["second"] = ["--exposure", str(exposure), "--camera", "table"]
        for kind, options in kinds.items():
            size = ["--width", "480", "--samples", "4", "-q"]
            picture = folder / f"{name}-{kind}.png"
            run([lightshaft, "render", scene, "--solution", solution, "-o", picture, *size, *options], "lightshaft render")
    return WALKS


def main():
    lightshaft, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    folder.mkdir(parents=True, exist_ok=True)

    def work(browser):
        models = look(browser, "models.mjs", [folder, *write_models(lightshaft, folder)])
        return models or look(browser, "walks.mjs", [folder, *write_walks(lightshaft, folder)])

    looked_at("the models and pages", work)


main()
