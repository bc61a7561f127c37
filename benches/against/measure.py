"""What is measured: each function yields one result (a dict) at a time."""
import json
import math
import os
import statistics
import subprocess
import tempfile

import exact
import pictures
import runners

LP_THREADS = {1: [0, 1], 2: [1, 2]}  # LP_NUM_THREADS worth trying for that many cores
SECONDS = 1e3


def frames_within(budget, ms):
    return max(3, min(300, int(budget * SECONDS / max(ms, 1e-3))))


def frames(a, jobs):
    """Frame times of a still camera, both renderers in turn."""
    for scene in jobs:
        for aa in a.aa:
            for mode in a.modes:
                try:
                    probe, agree = compare(a, scene, aa, mode)
                except runners.NotThere:
                    yield dict(scene=scene.name, aa=aa, mode=mode, missing=True)
                    continue
                for cores in a.cores:
                    row = dict(scene=scene.name, aa=aa, mode=mode, cores=cores, **agree)
                    row.update(in_turn(a, scene, aa, mode, cores, probe["median_ms"] / cores))
                    yield row


def compare(a, scene, aa, mode):
    """One picture of each; the stats of ours, and how the two agree."""
    with tempfile.TemporaryDirectory() as folder:
        theirs, dump = os.path.join(folder, "theirs.png"), os.path.join(folder, "dump")
        ours = os.path.join(folder, "ours.f32" if mode == "depth" else "ours.png")
        stats = runners.cullet(a.cullet, scene.path, scene.camera, aa, mode, 1, 1, ours)
        if mode == "depth" and aa != "none":
            return stats, {}  # a depth picture of ours is one sample per pixel, theirs the first of four
        runners.llvmpipe(scene.path, scene.camera, aa, mode, 1, 1, .01, 1, "draws", out=theirs, dump=dump, warmup=0)
        if mode == "depth":
            off = pictures.depth_off(dump, ours, scene.camera)
            return stats, dict(depth_off=off, agree=off <= pictures.DEPTH_LIMIT)
        flip = pictures.flip(a.cullet, theirs, ours)
        return stats, dict(flip=flip, agree=flip <= pictures.FLIP_LIMIT)


def same_picture(a, jobs):
    """What keeps the pictures apart: llvmpipe's with rows that go down and with exact conversions (see `exact`)."""
    for scene in jobs:
        for aa in a.aa:
            row = dict(scene=scene.name, aa=aa, mode="shaded")
            with tempfile.TemporaryDirectory() as folder:
                ours, theirs, down, exactly = (os.path.join(folder, name) for name in ("ours.png", "theirs.png", "down.ppm", "exact.ppm"))
                try:
                    runners.cullet(a.cullet, scene.path, scene.camera, aa, "shaded", 2, 1, ours)
                except runners.NotThere:
                    yield dict(row, missing=True)
                    continue
                runners.llvmpipe(scene.path, scene.camera, aa, "shaded", 2, 1, .01, 2, "draws", out=theirs, warmup=0)
                row["as_is"] = pictures.flip(a.cullet, theirs, ours)
                exact.picture(a.bench, scene.path, scene.camera, aa, None, down)
                row["down"] = pictures.flip(a.cullet, down, ours)
                for levels in exact.LEVELS:
                    exact.picture(a.bench, scene.path, scene.camera, aa, levels, exactly)
                    row[levels] = dict(own=pictures.flip(a.cullet, down, exactly), ours=pictures.flip(a.cullet, exactly, ours))
            yield row


def in_turn(a, scene, aa, mode, cores, guess_ms):
    key = "cpu_min_ms" if cores == 1 else "min_ms"
    best, ours, theirs = None, [], []
    guess = guess_ms

    def run_ours():
        nonlocal guess
        with tempfile.TemporaryDirectory() as folder:
            out = os.path.join(folder, "x.f32" if mode == "depth" else "x.ppm")
            stats = runners.cullet(a.cullet, scene.path, scene.camera, aa, mode, cores, frames_within(a.budget, guess), out)
            guess = stats["median_ms"]
            ours.append(stats)

    def run_theirs():
        nonlocal best
        if best is None:
            best = best_mode(a, scene, aa, mode, cores, key)
            theirs.append(best)
        else:
            theirs.append(runners.llvmpipe(scene.path, scene.camera, aa, mode, cores, 200, a.budget, best["lp_threads"], best["submit"]))

    for round_ in range(a.rounds):
        for run in (run_ours, run_theirs) if round_ % 2 == 0 else (run_theirs, run_ours):
            run()
    return dict(
        ours=summary(ours), theirs=summary(theirs), lp=best["lp_threads"], submit=best["submit"],
        stages=ours[-1]["stages"], triangles=ours[-1].get("triangles"), pixels=ours[-1].get("pixels_shaded"),
        scratch=ours[-1].get("scratch_bytes"), rss=ours[-1].get("peak_rss_bytes"), version=ours[-1].get("version"),
        theirs_version=best["gl_version"])


def best_mode(a, scene, aa, mode, cores, key):
    best = None
    for lp in LP_THREADS[cores]:
        for submit in ("draws", "instanced"):
            if submit == "instanced" and best and best["objects_drawn"] < 100:
                continue  # too few objects for instancing to matter
            got = runners.llvmpipe(scene.path, scene.camera, aa, mode, cores, 200, a.budget, lp, submit)
            if best is None or got[key] < best[key]:
                best = got
    return best


def summary(runs):
    return dict(median=statistics.median(r["median_ms"] for r in runs), min=min(r["min_ms"] for r in runs),
                cpu=min(r["cpu_min_ms"] for r in runs), medians=[r["median_ms"] for r in runs])


def turning(a, jobs):
    """A camera that turns 1 degree per frame about its up axis. llvmpipe keeps nothing from one frame to the next, so its time is
    that of still cameras along the way."""
    for scene in jobs:
        for aa in a.aa:
            for cores in a.cores:
                args = [a.turning, scene.path, scene.camera, "--threads", str(cores), "--aa", aa, "--budget", str(2 * a.budget)]
                done = subprocess.run(args, preexec_fn=runners.pin(cores), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
                if done.returncode == 2:
                    yield dict(scene=scene.name, aa=aa, cores=cores, missing=True)
                    continue
                if done.returncode:
                    raise RuntimeError("%s: exit code %d: %s" % (" ".join(args), done.returncode, done.stderr.strip()))
                got = json.loads(done.stdout)
                theirs = []
                for degrees in (0, got["degrees"] // 2, got["degrees"] - 1):
                    with tempfile.NamedTemporaryFile("w", suffix=".cam.json") as f:
                        json.dump(turned(scene.camera, degrees), f)
                        f.flush()
                        theirs.append(runners.llvmpipe(scene.path, f.name, aa, "shaded", cores, 30, a.budget / 4, cores, "draws")["median_ms"])
                yield dict(scene=scene.name, aa=aa, cores=cores, mode="turning", theirs=statistics.mean(theirs), **got)


def turned(path, degrees):
    """The camera of a file, turned to the left about its up vector (Rodrigues' formula)."""
    with open(path) as f:
        cam = json.load(f)
    up = cam.get("up", [0, 1, 0])
    length = math.sqrt(sum(x * x for x in up))
    k = [x / length for x in up]
    v = [t - e for t, e in zip(cam["target"], cam["eye"])]
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    cross = [k[1] * v[2] - k[2] * v[1], k[2] * v[0] - k[0] * v[2], k[0] * v[1] - k[1] * v[0]]
    dot = sum(x * y for x, y in zip(k, v))
    cam["target"] = [e + v[i] * c + cross[i] * s + k[i] * dot * (1 - c) for i, e in enumerate(cam["eye"])]
    return cam


def whole_process(a, jobs):
    """File in, PNG out, 1280x720: `cullet render X -o x.png`, nothing else said, against one frame of the llvmpipe program."""
    import llvmpipe_render
    llvmpipe_render.build()
    program = os.path.join(os.path.abspath(a.bench), "llvmpipe_render.py")
    for scene in jobs:
        with tempfile.TemporaryDirectory() as folder:
            png, stats = os.path.join(folder, "x.png"), os.path.join(folder, "stats.json")
            ours = [a.cullet, "render", scene.path, "-o", png]
            theirs = ["python3", program, "--scene", scene.path, "--camera", scene.camera, "--size", "1280x720",
                      "--frames", "1", "--warmup", "0", "--cull", "--no-blend", "--out", png, "--json"]
            walls = [(runners.wall_ms(ours, 2), runners.wall_ms(theirs, 2)) for _ in range(5)]
            runners.wall_ms(ours + ["--stats", stats], 2)
            with open(stats) as f:
                got = json.load(f)
            yield dict(scene=scene.name, mode="process", ours=statistics.median(w[0] for w in walls), theirs=statistics.median(w[1] for w in walls),
                       stages=got["stages"], total=got["total"], settings={k: got["settings"].get(k) for k in ("shading", "aa")})


def instructions(a, jobs):
    """Instructions per frame, one thread."""
    for scene in jobs:
        for aa in a.aa:
            for mode in a.modes:
                if mode == "depth" and aa != "none":
                    continue
                try:
                    count = runners.instructions_per_frame(a.cullet, scene.path, scene.camera, aa, mode)
                except runners.NotThere:
                    continue
                yield dict(scene=scene.name, aa=aa, mode=mode, instructions=count)
