"""One process of either renderer, pinned to the last cores this script may use (as the llvmpipe program pins itself)."""
import json
import os
import re
import subprocess
import tempfile
import time


class NotThere(Exception):
    """The program lacks the option asked for (exit code 2)."""


def pin(cores):
    """For `preexec_fn`."""
    cpus = sorted(os.sched_getaffinity(0))[-cores:]
    return lambda: os.sched_setaffinity(0, cpus)


# What OpenGL does otherwise than Cullet's defaults: the blend of two levels of a texture, and where triangles are shaded that share a pixel.
AS_OPENGL = ["--texture", "trilinear-log", "--edge-shading", "centre"]


def cullet_args(exe, scene, camera, aa, mode, threads, out):
    passes = "depth" if mode == "depth" else "color"
    return [exe, "render", scene, "--camera", camera, "-o", out, "--shading", "lambert", "--aa", aa,
            "--passes", passes, "--threads", str(threads)] + AS_OPENGL


def cullet(exe, scene, camera, aa, mode, cores, frames, out):
    """The --stats of `cullet render --frames`."""
    with tempfile.TemporaryDirectory() as folder:
        stats = os.path.join(folder, "stats.json")
        args = cullet_args(exe, scene, camera, aa, mode, cores, out)
        args += ["--frames", str(frames), "--stats", stats]
        done = subprocess.run(args, preexec_fn=pin(cores), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if done.returncode == 2:
            raise NotThere(done.stderr.strip())
        if done.returncode:
            raise RuntimeError("%s: exit code %d: %s" % (" ".join(args), done.returncode, done.stderr.strip()))
        with open(stats) as f:
            return json.load(f)


def llvmpipe(scene, camera, aa, mode, cores, frames, budget, lp, submit, out="/dev/null", dump=None, size=None, warmup=1):
    """The record of the llvmpipe program; it culls objects by itself within the time."""
    from llvmpipe_render import run
    args = ["--scene", scene, "--camera", camera, "--frames", frames, "--warmup", warmup, "--budget", budget, "--cpus", cores,
            "--msaa", 4 if aa == "msaa4" else 0, "--mode", mode, "--cull", "--no-blend", "--threads", lp, "--submit", submit, "--out", out]
    args += ["--dump", dump] if dump else []
    args += ["--size", size] if size else []
    return run(args)


def wall_ms(args, cores, code=0):
    """Wall time of a whole process."""
    start = time.perf_counter()
    done = subprocess.run(args, preexec_fn=pin(cores), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    wall = 1e3 * (time.perf_counter() - start)
    if done.returncode != code:
        raise RuntimeError("%s: exit code %d: %s" % (" ".join(args), done.returncode, done.stderr.strip()))
    return wall


def instructions_per_frame(exe, scene, camera, aa, mode):
    """Instructions of one warmed-up frame on one thread: a run of two frames less a run of one, under callgrind."""
    def start(frames):
        args = cullet_args(exe, scene, camera, aa, mode, 1, os.path.join(folder, "%d.ppm" % frames) if mode != "depth" else os.path.join(folder, "%d.f32" % frames))
        args = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"] + args + ["--frames", str(frames)]
        return subprocess.Popen(args, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    with tempfile.TemporaryDirectory() as folder:
        runs = [start(1), start(2)]
        counts = []
        for run in runs:
            said = run.communicate()[1]
            if run.returncode:
                raise NotThere(said[-500:])
            counts.append(int(re.search(r"Collected\s*:\s*(\d+)", said).group(1)))
        return counts[1] - counts[0]
