#!/bin/sh
# Import and study whatever real sets are there; `make real` runs it.
#     sh examples/real.sh DATA OUT BIN
# DATA is a folder with impact_hardness or piezo_strikes in it, or one of the two.
set -eu
data=$1 out=$2 bin=$3
here=$(dirname "$0")
found=

for place in "$data" "$data/impact_hardness"; do
    [ -z "$found" ] && [ -f "$place/labels.csv" ] || continue
    found=impacts
    recordings=$out/real-recordings/impact_hardness
    rm -rf "$recordings"
    "$bin/firstcontact" import "$place" --source real --out "$recordings"
    # The labels are those of a trigger, which comes up to 4 ms after the hit.
    "$bin/firstcontact" study --recordings "$recordings" --early-ms 4 --out "$out/real"
done

for place in "$data" "$data/piezo_strikes"; do
    [ -f "$place/hits.csv" ] && [ -f "$place/files.csv" ] || continue
    found=$found,strikes
    recordings=$out/real-recordings/piezo_strikes
    rm -rf "$recordings"
    mkdir -p "$out/real-recordings"
    "$bin/python" "$here/strike_events.py" "$place" "$out/real-recordings/strikes.csv"
    "$bin/firstcontact" import "$place/wav" --events "$out/real-recordings/strikes.csv" \
        --sensor piezo --source real --out "$recordings"
    "$bin/firstcontact" study --recordings "$recordings" --out "$out/real-strikes"
done

[ -n "$found" ] || {
    echo "make real: no labels.csv and no hits.csv in FIRSTCONTACT_DATA=$data"
    echo "Get the impacts (MIT licence) from github.com/Kev-HL/acoustic-hardness-classifier,"
    echo "converted to WAV as docs/how-to/real-impacts.md says, and name their folder:"
    echo "    make real FIRSTCONTACT_DATA=/path/to/impact_hardness"
    exit 2
} >&2
