#!/usr/bin/env python3
"""Cullet and Mesa's llvmpipe in turn on the same scenes, cores and cameras; writes a dated table of ratios.

  against_llvmpipe.py --bench DIR --assets DIR [--workloads DIR] [--parts pictures,frames,turning,process,instructions]
          [--only SCENE ...] [--aa none msaa4] [--modes shaded depth] [--cores 1 2] [--rounds 2] [--budget 1]
          [--cullet target/release/cullet] [--results RESULTS.jsonl] [--record benches/record/DATE-frames.md]

DIR of --bench holds the llvmpipe program (`llvmpipe_render.py`, `make_workloads.py`, `fit_camera.py`; its README says what to
install). Workloads that are missing are made there. Release builds of `cullet` and of the bench `turning` are expected:

  cargo build --release && cargo build --release -p cullet-benches

One measurement is one process: load, one frame to warm up, then frames until the budget in seconds is used. The two renderers
alternate, pinned to the same cores, Cullet first in even rounds. llvmpipe runs in its best mode: every LP_NUM_THREADS and way of
submitting that makes sense is tried in the first round, and the best by CPU time (one core) or wall time (two) is kept.
Every result goes to the results file at once; the table is made from that file, so that parts may be run at different times
(--parts none only writes the table). Exit code 1: pictures differ by more than FLIP .02; --parts pictures says what keeps them apart.
"""
import argparse
import json
import os
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "against"))
import report  # noqa: E402
import scenes  # noqa: E402
import measure  # noqa: E402

PARTS = {
    "pictures": measure.same_picture,
    "frames": measure.frames,
    "turning": measure.turning,
    "process": measure.whole_process,
    "instructions": measure.instructions,
}


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--bench", required=True, help="folder of llvmpipe_render.py")
    ap.add_argument("--assets", required=True, help="folder of real models (holds scenes/)")
    ap.add_argument("--workloads", default=os.path.join(HERE, "../target/workloads"))
    ap.add_argument("--cullet", default=os.path.join(HERE, "../target/release/cullet"))
    ap.add_argument("--turning", default=os.path.join(HERE, "../target/release/turning"))
    ap.add_argument("--parts", default=",".join(PARTS), help="comma-separated, or none")
    ap.add_argument("--only", nargs="*", help="names of scenes")
    ap.add_argument("--aa", nargs="*", default=["none", "msaa4"], choices=["none", "msaa4"])
    ap.add_argument("--modes", nargs="*", default=["shaded", "depth"], choices=["shaded", "depth"])
    ap.add_argument("--cores", nargs="*", type=int, default=[1, 2], choices=[1, 2])
    ap.add_argument("--rounds", type=int, default=2)
    ap.add_argument("--budget", type=float, default=1.0, help="seconds of frames per process")
    ap.add_argument("--results", default=os.path.join(HERE, "../target/against.jsonl"))
    ap.add_argument("--fresh", action="store_true", help="forget earlier results")
    ap.add_argument("--record", help="where to write the table [benches/record/DATE-frames.md]")
    a = ap.parse_args()
    parts = [] if a.parts == "none" else a.parts.split(",")
    for part in parts:
        if part not in PARTS:
            ap.error("no part %r; there are %s" % (part, ", ".join(PARTS)))
    sys.path.insert(0, os.path.abspath(a.bench))

    if a.fresh and os.path.exists(a.results):
        os.remove(a.results)
    jobs = scenes.all_scenes(a.bench, a.workloads, a.assets, a.only)
    start = time.time()
    for part in parts:
        for row in PARTS[part](a, jobs):
            row["part"] = part
            row["at"] = round(time.time())
            with open(a.results, "a") as f:
                f.write(json.dumps(row) + "\n")
            print("%5.0f s  %s" % (time.time() - start, report.line(row)), flush=True)

    rows = report.read(a.results)
    record = a.record or os.path.join(HERE, "record", time.strftime("%Y-%m-%d-frames.md"))
    with open(record, "w") as f:
        f.write(report.markdown(rows, a))
    print("wrote", os.path.relpath(record))
    bad = [r for r in rows if r.get("agree") is False]
    for r in bad:
        print("pictures differ: %s %s %s" % (r["scene"], r["mode"], r["aa"]), file=sys.stderr)
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
