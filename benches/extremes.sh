#!/usr/bin/env bash
# Instructions of one frame of each extreme (`cullet synth --list`) and of its ordinary twin, counted
# by valgrind: no clock is asked, so a busy machine gives the same figures.
# Usage: benches/extremes.sh [CULLET], by default target/release/cullet.
set -euo pipefail
cd "$(dirname "$0")/.."
cullet=${1:-target/release/cullet}

# What a run of two frames more takes; loading, preparing and encoding cancel out.
run() {
    valgrind --tool=callgrind --callgrind-out-file=/dev/null \
        "$cullet" render "synth:$1" --camera 0 --size 640x360 --threads 1 --frames "$2" -o - \
        2>&1 >/dev/null | sed -n 's/.*Collected : //p'
}
frame() {
    echo $((($(run "$1" 3) - $(run "$1" 1)) / 2))
}

printf '| extreme | instructions per frame | ordinary twin | ratio |\n| --- | ---: | ---: | ---: |\n'
status=0
names=$("$cullet" synth --list | grep -o '^extreme:[a-z-]\+')
for name in $names; do
    extreme=$(frame "$name")
    ordinary=$(frame "$name:ordinary")
    awk -v name="${name#extreme:}" -v a="$extreme" -v b="$ordinary" 'BEGIN {
        printf "| %s | %.2f M | %.2f M | %.2f |\n", name, a / 1e6, b / 1e6, a / b
        exit a > 2 * b || a <= 0 || b <= 0 # none at all: it did not run
    }' || status=1
done
exit $status # 1 if one costs more than twice as much as its twin
