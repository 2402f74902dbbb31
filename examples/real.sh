#!/bin/sh
# Import and study all available real sets and write one page; `make real` runs this.
#     sh examples/real.sh DATA OUT BIN
# DATA is a folder that contains impact_hardness, piezo_strikes, biotac_hold or spring_drops, or one
# of these.
set -eu
data=$1 out=$2/real bin=$3
here=$(dirname "$0")
found=

# Start a set with empty folders.
begin() {
    found=$1 set=$out/$1
    rm -rf "$set/recordings" "$set/noise" "$set/tables"
    mkdir -p "$set/tables"
}

for place in "$data" "$data/impact_hardness"; do
    [ -f "$place/labels.csv" ] || continue
    begin impact_hardness
    "$bin/firstcontact" import "$place" --source real --out "$set/recordings"
    printf 'session,front_end\n*,MEMS microphone\n' > "$set/front_ends.csv"
    # The labels come from a trigger, which is up to 4 ms late.
    "$bin/firstcontact" study --recordings "$set/recordings" --early-ms 4 --out "$set"
    break
done

for place in "$data" "$data/piezo_strikes"; do
    [ -f "$place/hits.csv" ] && [ -f "$place/files.csv" ] || continue
    begin piezo_strikes
    "$bin/python" "$here/strike_events.py" "$place" "$set/tables/strikes.csv" \
        "$set/front_ends.csv" "$set/tables/noise.wav"
    "$bin/firstcontact" import "$place/wav" --events "$set/tables/strikes.csv" \
        --sensor piezo --source real --out "$set/recordings"
    if [ -f "$set/tables/noise.wav" ]; then
        "$bin/firstcontact" import "$set/tables/noise.wav" --sensor piezo --source real \
            --out "$set/noise"
    fi
    "$bin/firstcontact" study --recordings "$set/recordings" --out "$set"
    break
done

for place in "$data" "$data/biotac_hold/data"; do
    ls "$place"/*_HOLD.mat > /dev/null 2>&1 || continue
    begin biotac_hold
    "$bin/python" "$here/biotac_tables.py" "$place" "$set/tables/labels.csv" "$set/tables/channels.csv"
    "$bin/firstcontact" import "$place" --labels "$set/tables/labels.csv" \
        --channels "$set/tables/channels.csv" --source real --out "$set/recordings"
    printf 'session,front_end\n*,BioTac\n' > "$set/front_ends.csv"
    "$bin/firstcontact" study --recordings "$set/recordings" --out "$set"
    break
done

for place in "$data" "$data/spring_drops"; do
    [ -f "$place/drops.npz" ] || continue
    begin spring_drops
    "$bin/python" "$here/spring_drops.py" "$place" "$set/tables/drops.npz"
    "$bin/firstcontact" import "$set/tables/drops.npz" --out "$set/recordings"
    printf 'session,front_end\n*,accelerometer of an impactor\n' > "$set/front_ends.csv"
    "$bin/firstcontact" study --recordings "$set/recordings" --parts stiffness --out "$set"
    break
done

[ -n "$found" ] || {
    echo "make real: FIRSTCONTACT_DATA=$data holds no real set (no labels.csv, hits.csv, drops.npz or *_HOLD.mat): get one as docs/reference/results.md describes, and name its folder with make real FIRSTCONTACT_DATA=FOLDER"
    exit 2
} >&2

# Simulate pinches with a seed. The folder gets its name once it is complete.
twin() {
    place=$1 seed=$2
    shift 2
    rm -rf "$place" "$place.part"
    "$bin/firstcontact" simulate --condition everyday --pinches-per-block 60 \
        --pinches-per-object 30 --seed "$seed" --out "$place.part" "$@"
    mv "$place.part" "$place"
}
# Training data that belongs to none of the sets.
[ -d "$out/twin-pinches" ] || twin "$out/twin-pinches" 7
# The same pinches with modelled electronic noise and with a real converter's noise.
set --
volts=$out/piezo_strikes/tables/noise_volts.wav
if [ -f "$volts" ]; then
    rm -rf "$out/noises"
    "$bin/firstcontact" import "$volts" --sensor piezo --source real --out "$out/noises/quiet"
    twin "$out/noises/modelled" 8
    twin "$out/noises/teensy_4.0" 8 --noise "$out/noises/quiet/000_noise_volts.mcap"
    set -- --noises "$out/noises/modelled" "$out/noises/teensy_4.0"
fi
"$bin/firstcontact" sets "$out" --twin "$out/twin-pinches" "$@"
