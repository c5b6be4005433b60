"""Puts Embree 4.4 into the folder given, unless the system has 4.3 or later. Run by build.rs.

Prints "system VERSION" or "provisioned"; anything that goes wrong is one line on standard error and
exit code 1. The libraries come from a wheel of PyPI, fetched with pip whatever the local Python's
version is, and are used only if their SHA-256 is the one below.
"""

import ctypes
import hashlib
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import zipfile

WHEEL = "embreex==4.4.0.post1"
# Each keeps its name: libembree4 asks for libtbb by it, and finds it in its own folder.
LIBRARIES = {
    "libembree4-4aef3270.so.4": "aa4eb9d81e30237d032418832efd9caee19bead50f49939fb08347a053898c7a",
    "libtbb-dcf63f8c.so.12": "08d7ce01dcce5c49f874ee91ba8dad75ee3aa1838d5ce8a92f5b2ec98b9df2ed",
}


def system_version():
    """(major, minor) of the system's Embree 4, or None."""
    try:
        embree = ctypes.CDLL("libembree4.so.4")
        embree.rtcNewDevice.restype = ctypes.c_void_p
        embree.rtcGetDeviceProperty.restype = ctypes.c_ssize_t
        embree.rtcGetDeviceProperty.argtypes = [ctypes.c_void_p, ctypes.c_int]
        embree.rtcReleaseDevice.argtypes = [ctypes.c_void_p]
        device = embree.rtcNewDevice(b"threads=1")
        if not device:
            return None
        version = tuple(embree.rtcGetDeviceProperty(device, part) for part in (1, 2))
        embree.rtcReleaseDevice(device)
        return version
    except (OSError, AttributeError):
        return None


def is_intact(path, digest):
    return path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest() == digest


def download(folder):
    """Path of the wheel, fetched into `folder`."""
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-input"]
    command += ["--disable-pip-version-check", "--retries", "1", "--timeout", "20", "--dest", folder]
    command += ["--no-deps", "--only-binary=:all:", "--implementation", "cp", "--python-version", "3.12"]
    command += ["--platform", "manylinux_2_28_x86_64", WHEEL]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    wheels = list(pathlib.Path(folder).glob("*.whl"))
    if result.returncode != 0 or len(wheels) != 1:
        said = [line for line in result.stderr.splitlines() if line.strip()]
        raise RuntimeError(f"pip could not download {WHEEL}: {said[-1] if said else 'it said nothing'}")
    return wheels[0]


def provision(folder):
    folder.mkdir(parents=True, exist_ok=True)
    if all(is_intact(folder / name, digest) for name, digest in LIBRARIES.items()):
        return
    # In the same folder, so that the last step is a rename: another build may run at this moment.
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        with zipfile.ZipFile(download(scratch)) as wheel:
            members = {pathlib.PurePosixPath(info.filename).name: info for info in wheel.infolist()}
            for name, digest in LIBRARIES.items():
                if name not in members:
                    raise RuntimeError(f"{WHEEL} holds no {name}")
                path = pathlib.Path(scratch, name)
                path.write_bytes(wheel.read(members[name]))
                if not is_intact(path, digest):
                    raise RuntimeError(f"{name} of {WHEEL} does not have the expected SHA-256")
                # An old date, or cargo takes the file for a change that asks for another run.
                when = time.mktime(members[name].date_time + (0, 0, -1))
                os.utime(path, (when, when))
                os.replace(path, folder / name)


def main():
    version = system_version()
    if version is not None and (4, 3) <= version < (5, 0):
        print("system {}.{}".format(*version))
        return 0
    try:
        provision(pathlib.Path(sys.argv[1]))
    except (OSError, RuntimeError, zipfile.BadZipFile) as error:
        print(error, file=sys.stderr)
        return 1
    print("provisioned")
    return 0


sys.exit(main())
