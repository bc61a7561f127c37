"""Results into markdown."""
import json
import math
import os
import platform
import subprocess
import time

import pictures
from exact import LEVELS

# Least times of parts, ns on one core, measured on their own on the machine of performance.md 2.
# Depth and coverage of a full 1920x1080 layer with clear: .4 ms; trilinear texels: 3.2 (axis) to 6.6 (90 degrees) per pixel;
# triangles of a few pixels, depth only, set-up and vertices included: 13.5; set-up of those that are then rejected: 3.2.
LAYER_MS, TEXEL_NS, TRIANGLE_NS, REJECT_NS = .4, 3.2, 13.5, 3.2
EUC_TINY_MS = 60


def read(path):
    """The last result of each kind."""
    kept = {}
    with open(path) as f:
        for text in f:
            row = json.loads(text)
            kept[tuple(row.get(k) for k in ("part", "scene", "aa", "mode", "cores"))] = row
    return list(kept.values())


def line(row):
    what = " ".join(str(row[k]) for k in ("part", "scene", "aa", "mode", "cores") if k in row)
    if row.get("missing"):
        return what + ": not there"
    if row["part"] == "frames":
        agree = " flip %.4f" % row["flip"] if "flip" in row else " depth off %.4f" % row["depth_off"] if "depth_off" in row else ""
        return "%s: llvmpipe %.2f cullet %.2f ms, x%.2f, cpu %s%s" % (
            what, row["theirs"]["median"], row["ours"]["median"], ratio(row), cpu_ratio([row]), agree)
    if row["part"] == "pictures":
        exact = ", ".join("%s: own %.4f, ours %.4f" % (levels, row[levels]["own"], row[levels]["ours"]) for levels in LEVELS)
        return "%s: flip %.4f, rows down %.4f; exact, %s" % (what, row["as_is"], row["down"], exact)
    if row["part"] == "turning":
        return "%s: still %.2f turning %.2f ms, llvmpipe %.2f" % (what, row["still_ms"], row["turning_ms"], row["theirs"])
    if row["part"] == "process":
        return "%s: llvmpipe %.0f cullet %.0f ms" % (what, row["theirs"], row["ours"])
    return "%s: %.1f M instructions" % (what, row["instructions"] / 1e6)


def ratio(row):
    return row["theirs"]["median"] / row["ours"]["median"]


def cpu_ratio(rows):
    """The mean of one core; of several the clock of a process lags behind for threads that run elsewhere, and the least says nothing."""
    if any(row["cores"] != 1 for row in rows):
        return "-"
    return "%.2f" % mean(row["theirs"]["cpu"] / row["ours"]["cpu"] for row in rows)


def limit_ms(row):
    """What the parts of this frame would take by themselves at the measured limits, each core used fully."""
    t = row.get("triangles") or {}
    culled = t.get("culled", {})
    rejected = sum(v for k, v in culled.items() if k != "with_object" and isinstance(v, (int, float)))
    ms = LAYER_MS + 1e-6 * (TRIANGLE_NS * t.get("drawn", 0) + REJECT_NS * rejected)
    if row["mode"] == "shaded":
        ms += 1e-6 * TEXEL_NS * (row.get("pixels") or 0)
    return ms / row["cores"]


def mean(values):
    values = list(values)
    return math.exp(sum(map(math.log, values)) / len(values)) if values else float("nan")


def table(head, rows):
    align = "| " + " | ".join("---" if i == 0 else "---:" for i in range(len(head))) + " |"
    body = ["| " + " | ".join(map(str, r)) + " |" for r in rows]
    return "\n".join(["| " + " | ".join(head) + " |", align] + body) + "\n"


def markdown(rows, a):
    part = {p: [r for r in rows if r["part"] == p and not r.get("missing")] for p in ("pictures", "frames", "turning", "process", "instructions")}
    missing = sorted({r["aa"] for r in rows if r.get("missing")})
    counts = {(r["scene"], r["aa"], r["mode"]): r["instructions"] for r in part["instructions"]}
    out = [header(rows, part["frames"], missing)]
    if part["frames"]:
        out += [still(part["frames"], counts), means(part["frames"]), bars(part["frames"]), stages(part["frames"])]
    if part["pictures"]:
        out.append(same_picture(part["pictures"]))
    if part["turning"]:
        out.append(turning(part["turning"]))
    if part["process"]:
        out.append(process(part["process"]))
    return "\n".join(out)


def header(rows, frames, missing):
    cpu = next((x.split(":")[1].strip() for x in open("/proc/cpuinfo") if x.startswith("model name")), platform.machine())
    family = [x.split(":")[1].strip() for x in open("/proc/cpuinfo") if x.startswith(("cpu family", "model\t"))][:2]
    commit = subprocess.run(["git", "log", "-1", "--format=%h"], cwd=os.path.dirname(os.path.abspath(__file__)), stdout=subprocess.PIPE, text=True).stdout.strip()
    at = [r["at"] for r in rows if "at" in r] or [time.time()]
    day, span = time.strftime("%Y-%m-%d", time.gmtime(max(at))), [time.strftime("%H:%M", time.gmtime(t)) for t in (min(at), max(at))]
    mesa = next((r["theirs_version"] for r in frames), "")
    text = "# %s: frames against llvmpipe\n\n" % day
    text += "- machine: %d cores %s (family %s), virtual, shared; %s to %s UTC\n" % (os.cpu_count(), cpu, " model ".join(family), *span)
    text += "- commit: %s; llvmpipe: %s\n" % (commit, mesa)
    text += "- command: `benches/against_llvmpipe.py --bench DIR --assets DIR`, its parts maybe run apart\n"
    if missing:
        text += "- not measured, since this `cullet` has not got it: %s\n" % ", ".join(missing)
    return text


def still(frames, counts):
    text = """## Still camera, 1920x1080

Milliseconds per frame: median, in brackets on one core the least CPU time. `ratio` = median of llvmpipe / median of Cullet, `cpu` = the
same of the least CPU times, which other work on the machine disturbs less. `limit`: what the parts of this frame (a layer of depth,
triangles drawn and rejected, pixels shaded, as counted by Cullet) would take by themselves at the speeds that kernels alone
have reached (%.1f ms, %.1f, %.1f and %.1f ns; taken to scale with cores); `of it` = median of Cullet / limit. Without multisampling only.
`agree`: mean FLIP of the two pictures (at most %.2f), or the share of pixels whose depth differs (at most %.2f).

""" % (LAYER_MS, TRIANGLE_NS, REJECT_NS, TEXEL_NS, pictures.FLIP_LIMIT, pictures.DEPTH_LIMIT)
    head = ["scene", "mode", "aa", "cores", "llvmpipe", "its mode", "Cullet", "ratio", "cpu", "limit", "of it", "M instr.", "agree"]
    body = []
    for r in frames:
        limit = limit_ms(r) if r["aa"] == "none" else None
        count = counts.get((r["scene"], r["aa"], r["mode"])) if r["cores"] == 1 else None
        agree = "%.4f" % (r["flip"] if "flip" in r else r["depth_off"]) if "agree" in r else "-"
        body.append([r["scene"], r["mode"], r["aa"], r["cores"], cell(r, "theirs"), "LP %d, %s" % (r["lp"], r["submit"]), cell(r, "ours"),
                     "**%.2f**" % ratio(r), cpu_ratio([r]), "%.2f" % limit if limit else "-",
                     "%.1f" % (r["ours"]["median"] / limit) if limit else "-", "%.1f" % (count / 1e6) if count else "-",
                     agree if r.get("agree") is not False else agree + " NO"])
    return text + table(head, body)


def cell(row, whose):
    times = row[whose]
    return "%.2f (%.2f)" % (times["median"], times["cpu"]) if row["cores"] == 1 else "%.2f" % times["median"]


def means(frames):
    groups = []
    for mode in ("shaded", "depth"):
        for aa in ("none", "msaa4"):
            for cores in (1, 2):
                rows = [r for r in frames if (r["mode"], r["aa"], r["cores"]) == (mode, aa, cores)]
                if rows:
                    worst = min(rows, key=ratio)
                    groups.append([mode, aa, cores, len(rows), "**%.2f**" % mean(map(ratio, rows)), cpu_ratio(rows),
                                   "%.2f %s" % (ratio(worst), worst["scene"])])
    return "## Geometric means\n\n" + table(["mode", "aa", "cores", "scenes", "ratio", "cpu", "least ratio"], groups)


def bars(frames):
    """What issue asks are made of: msaa against none, two cores against one, memory."""
    by = {(r["scene"], r["mode"], r["aa"], r["cores"]): r for r in frames}
    body = []
    for name in dict.fromkeys(r["scene"] for r in frames):
        def ms(who, aa, cores):
            r = by.get((name, "shaded", aa, cores))
            return r[who]["median"] if r else None

        def over(x, y):
            return "%.2f" % (x / y) if x and y else "-"
        first = by.get((name, "shaded", "none", 1)) or {}
        body.append([name, over(ms("ours", "msaa4", 1), ms("ours", "none", 1)), over(ms("theirs", "msaa4", 1), ms("theirs", "none", 1)),
                     over(ms("ours", "none", 1), ms("ours", "none", 2)), over(ms("theirs", "none", 1), ms("theirs", "none", 2)),
                     "%.1f" % (first["scratch"] / 2**20) if first.get("scratch") else "-"])
    text = "## Multisampling, cores, memory (shaded)\n\n"
    text += table(["scene", "msaa4 / none, one core", "llvmpipe's", "one core / two", "llvmpipe's", "scratch MiB"], body)
    tiny = by.get(("tiny", "shaded", "none", 1))
    if tiny:
        text += "\n`tiny`, one core: %.1f ms trilinear; the crate `euc` 0.5.3 takes %d ms with nearest texels (bench README, another machine).\n" % (tiny["ours"]["median"], EUC_TINY_MS)
    return text


def stages(frames):
    rows = [r for r in frames if (r["mode"], r["aa"], r["cores"]) == ("shaded", "none", 1)]
    names = ["cull", "geometry", "raster", "shade", "resolve"]
    body = []
    for r in rows:
        t = r.get("triangles") or {}
        culled = t.get("culled", {})
        body.append([r["scene"]] + ["%.2f" % r["stages"][n] if n in r["stages"] else "-" for n in names]
                    + [t.get("drawn", "-"), culled.get("facing_away", "-"), r.get("pixels", "-")])
    return "## Where the time goes (shaded, aa none, one core, ms)\n\n" + table(["scene"] + names + ["triangles drawn", "facing away", "pixels shaded"], body)


def same_picture(rows):
    def marked(flip):
        return "%.4f" % flip if flip <= pictures.FLIP_LIMIT else "**%.4f**" % flip
    body = [[r["scene"], r["aa"], marked(r["as_is"]), marked(r["down"])] + [marked(r[levels][which]) for which in ("own", "ours") for levels in LEVELS] for r in rows]
    head = ["scene", "aa", "Cullet, as llvmpipe draws", "the same, rows down"] + ["%s, %s" % (who, levels) for who in ("llvmpipe exact, from itself", "from Cullet") for levels in LEVELS]
    return ("""## What keeps the pictures apart

Mean FLIP at 1920x1080 (at most %.2f asked for; what is above is set in bold). llvmpipe converts from and to sRGB by approximations, and
keeps textures and pixels in 8 bits; as OpenGL's rows go up, its samples lie mirrored in a picture whose rows go down. `rows down`, and all
columns that follow: it drew the scene mirrored, so that samples lie alike. `exact`: it drew into floats from textures of floats, so that
it had nothing to convert: those were made linear before, and the picture was made sRGB afterwards, exactly. `floats`: levels of
textures are means, not rounded. `codes`: each level is rounded to 8-bit sRGB, and the next one made of that.

""" % pictures.FLIP_LIMIT + table(head, body))


def turning(rows):
    body = [[r["scene"], r["aa"], r["cores"], "%.2f" % r["still_ms"], "%.2f" % r["turning_ms"], "%.2f" % (r["turning_ms"] / r["still_ms"]),
             "%.2f" % r["theirs"], "%.2f" % (r["theirs"] / r["turning_ms"])] for r in rows]
    return ("## Turning camera\n\n1 degree per frame about the up axis, %s frames; medians in ms. llvmpipe keeps nothing between frames: its figure is the mean of\nstill cameras at the start, in the middle and at the end of the turn.\n\n" % rows[0]["degrees"]
            + table(["scene", "aa", "cores", "still", "turning", "turning / still", "llvmpipe", "ratio"], body))


def process(rows):
    body = []
    for r in rows:
        s = r["stages"]
        frame = sum(s.get(k, 0) for k in ("cull", "geometry", "raster", "shade", "resolve"))
        body.append([r["scene"], "%.0f" % r["theirs"], "%.0f" % r["ours"], "**%.2f**" % (r["theirs"] / r["ours"]), "%.0f" % s.get("load", 0), "%.0f" % s.get("prepare", 0), "%.0f" % frame, "%.0f" % s.get("encode", 0)])
    said = rows[0].get("settings", {})
    return ("## Whole process, 1280x720\n\n`cullet render X -o x.png` with default options (%s, aa %s, camera auto) against one frame of the llvmpipe program (lambert, no\nmultisampling, its own camera); wall ms on two cores, medians of 5 in turn, and stages of ours.\n\n" % (said.get("shading"), said.get("aa"))
            + table(["scene", "llvmpipe", "Cullet", "ratio", "load", "prepare", "frame", "encode"], body))
