#!/bin/sh
# Draws the tile textures with OpenImageIO's oiiotool: tiles of 20 cm, 32 pixels with a joint of 2, in four blues.
set -eu
cd "$(dirname "$0")"
oiiotool --create 64x64 3 --fill:color=0.82,0.87,0.88 64x64 \
    --fill:color=0.42,0.66,0.74 30x30+1+1 --fill:color=0.47,0.70,0.77 30x30+33+1 \
    --fill:color=0.46,0.71,0.79 30x30+1+33 --fill:color=0.40,0.64,0.73 30x30+33+33 -o tile.tmp.png
draw() { # name, tiles across, tiles up
    copies=""
    i=0
    while [ "$i" -lt "$(($2 * $3 / 4))" ]; do copies="$copies tile.tmp.png"; i=$((i + 1)); done
    # shellcheck disable=SC2086
    oiiotool $copies --mosaic "$(($2 / 2))x$(($3 / 2))" -d uint8 -o "$1"
}
draw tiles_floor.png 30 20
draw tiles_long.png 30 10
draw tiles_short.png 20 10
rm -f tile.tmp.png
