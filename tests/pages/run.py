"""Looks at the pages of `compare` and `profile` in a headless Chromium: run.py LIGHTSHAFT FOLDER.

FOLDER gets the pages and their screenshots. Where what it needs (browser.py) cannot be had, or there is no Embree to
compare with, it says SKIPPED and why, with exit code 0; with LIGHTSHAFT_REQUIRE_BROWSER=1 that is a failure.
"""

import os
import pathlib
import sys

from browser import PROJECT, look, looked_at, run

SCENE = PROJECT / "scenes/cornell-box/scene.toml"


def write_points(folder):
    """Points on the floor, and values there that are made up: how far off they are does not matter here."""
    points, reference = folder / "points.txt", folder / "reference.csv"
    places = [(x, z) for x in (100, 250, 400) for z in (100, 250, 400)]
    points.write_text("".join(f"{x} 0 {z} 0 1 0\n" for x, z in places))
    names = [f"{kind}_{channel}" for kind in ("total", "direct", "se_total", "se_direct") for channel in "rgb"]
    reference.write_text("\n".join([",".join(names)] + [",".join(["5"] * 3 + ["4"] * 3 + ["0"] * 6)] * len(places)) + "\n")
    return ["--points", points, "--reference", reference, "--samples", "64"]


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


def main():
    lightshaft, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    looked_at("the pages", lambda browser: look(browser, "look.mjs", [folder, *write_pages(lightshaft, folder)]))


main()
