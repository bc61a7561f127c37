"""What is drawn: generated workloads and real models, each with a camera file."""
import os
import subprocess
import sys

WORKLOADS = ["fill_b2f", "fill_f2b", "tiny", "city", "forest", "interior"]
MODELS = ["FlightHelmet", "chess-board", "low-poly-jungle", "MetalRoughSpheresNoTextures"]


class Scene:
    def __init__(self, name, path, camera):
        self.name, self.path, self.camera = name, path, camera


def all_scenes(bench, folder, assets, only):
    """The scenes asked for; makes workloads and cameras that are missing."""
    os.makedirs(folder, exist_ok=True)
    wanted = [n for n in WORKLOADS + MODELS if not only or n in only]
    return [workload(bench, folder, n) if n in WORKLOADS else model(bench, folder, assets, n) for n in wanted]


def workload(bench, folder, name):
    path, camera = os.path.join(folder, name + ".glb"), os.path.join(folder, name + ".cam.json")
    if not (os.path.exists(path) and os.path.exists(camera)):
        kind = name.split("_")[0]
        subprocess.check_call([sys.executable, os.path.join(bench, "make_workloads.py"), folder, "--only", kind])
    return Scene(name, path, camera)


def model(bench, folder, assets, name):
    inside = os.path.join(assets, "scenes", name)
    found = [f for f in sorted(os.listdir(inside)) if f.endswith((".glb", ".gltf"))]
    path, camera = os.path.join(inside, found[0]), os.path.join(folder, name + ".cam.json")
    if not os.path.exists(camera):
        fit = [sys.executable, os.path.join(bench, "fit_camera.py"), path, camera, "--fill", "1.4"]
        subprocess.check_call(fit, stdout=subprocess.DEVNULL)
    return Scene(name, path, camera)
