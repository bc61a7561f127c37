#!/usr/bin/env python3
"""docs/tradeoff.md from what `cullet tradeoff` wrote and printed.

    cullet tradeoff scenes/city.glb scenes/interior.glb scenes/showpiece.glb --out report > report/printed.txt
    python3 benches/tradeoff_docs.py report

Copies the plot and the table to docs/, and replaces in docs/tradeoff.md what stands between
`<!-- fronts -->` and `<!-- /fronts -->` (the fronts, as printed) and between `<!-- findings -->` and
`<!-- /findings -->` (machine, scenes and findings). The words between are nobody's but the command's.
"""

import json
import pathlib
import shutil
import sys
import textwrap

DOCS = pathlib.Path(__file__).resolve().parent.parent / "docs"


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    report = pathlib.Path(sys.argv[1])
    found = json.loads((report / "tradeoff.json").read_text())
    printed = (report / "printed.txt").read_text()
    page = DOCS / "tradeoff.md"
    text = page.read_text()
    text = replaced(text, "fronts", fronts(printed))
    text = replaced(text, "findings", findings(found))
    page.write_text(text)
    for name in ["tradeoff.svg", "tradeoff.csv"]:
        shutil.copyfile(report / name, DOCS / name)


def replaced(text, name, new):
    """`text` with `new` between the marks of this name."""
    start, end = f"<!-- {name} -->\n", f"<!-- /{name} -->"
    before, rest = text.split(start)
    _, after = rest.split(end)
    return f"{before}{start}{new}{end}{after}"


def fronts(printed):
    """The table that comes first, up to the first empty line."""
    return f"```text\n{printed.split(chr(10) * 2)[0]}\n```\n"


def findings(found):
    machine, settings = found["machine"], found["settings"]
    load = machine["load_per_core"]
    load = "" if load is None else f"; load {load:.2f} per core when it began"
    parts = [
        wrapped(
            f"{machine['processor']}, {machine['cores']} cores, {machine['simd']}, {machine['system']}, "
            f"{machine['build']} build{load}; {settings['size'][0]} x {settings['size'][1]} px, "
            f"{settings['clock']}; budget {settings['budget_s']:g} s, took {settings['took_s']:.0f} s."
        )
    ]
    for scene in found["scenes"]:
        left_out = f"; left out: {', '.join(scene['left_out'])}" if scene["left_out"] else ""
        words = f"{scene['scene']}: camera {scene['camera']}, {scene['rounds']} rounds, {scene['reference']}"
        parts.append(item(f"{words}{left_out}."))
    if found["left_out"]:
        parts.append(item(f"left out: {', '.join(found['left_out'])}."))
    verdicts = [one for one in found["findings"] if not is_trade(one)]
    trades = [one for one in found["findings"] if is_trade(one)]
    parts.append("")
    parts += [item(f"**{one['kind']}** {one['text']}") for one in verdicts]
    parts.append("")
    parts += [item(one["text"]) for one in trades]
    return "\n".join(parts) + "\n"


def is_trade(finding):
    """Whether this is what one value of one knob gains and costs."""
    return finding["kind"] == "measured" and " times the time of the default: " in finding["text"]


def item(text):
    return wrapped(text, "* ", "  ")


def wrapped(text, first="", rest=""):
    return textwrap.fill(
        text, 100, initial_indent=first, subsequent_indent=rest, break_long_words=False, break_on_hyphens=False
    )


main()
