"""Do the two renderers draw the same?"""
import array
import json
import os
import subprocess

FLIP_LIMIT = .02
# Share of pixels whose depths may differ: silhouettes, where the two snap vertices differently by less than 1/256 px.
DEPTH_LIMIT = .01


def flip(cullet, a, b):
    """Mean FLIP of two PNG files."""
    done = subprocess.run([cullet, "diff", a, b, "--metric", "flip", "--json"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    if done.returncode not in (0, 1):
        raise RuntimeError("cullet diff: exit code %d" % done.returncode)
    return json.loads(done.stdout)["metrics"]["flip"]


def depth_off(window, linear, camera, step=7):
    """The share of pixels (every `step`th is looked at) whose distances differ by more than two codes of the 24-bit window
    depth and one in a thousand, or that only one of the two draws.

    `window`: float32 window depth of the llvmpipe program. `linear`: float32 distance along the view axis, inf for nothing.
    """
    with open(camera) as f:
        cam = json.load(f)
    near, far = cam["znear"], cam["zfar"]
    z, d = floats(window), floats(linear)
    if len(z) != len(d):
        raise RuntimeError("depth pictures of different sizes")
    off = looked = 0
    for i in range(0, len(z), step):
        looked += 1
        nothing = z[i] >= 1.0
        if nothing or d[i] == float("inf"):
            # The last code of window depth is also what is just before the far plane.
            off += nothing != (d[i] == float("inf")) and not d[i] > .9 * far
            continue
        distance = near * far / (far - z[i] * (far - near))
        code = distance * distance * (1 / near - 1 / far) / (1 << 24)
        off += abs(distance - d[i]) > 2 * code + 1e-3 * distance
    return off / looked


def floats(path):
    values = array.array("f")
    with open(path, "rb") as f:
        values.fromfile(f, os.path.getsize(path) // 4)
    return values
