# Prints how many pixels each object covers, by the names of the Cryptomatte manifest.
import json
import struct
import sys

try:
    import OpenImageIO as oiio
except ImportError:
    print("no OpenImageIO")
    sys.exit(0)

file = oiio.ImageInput.open(sys.argv[1])
spec = file.spec()
pixels = file.read_image("float")
manifests = [a for a in spec.extra_attribs if a.name.startswith("cryptomatte/") and a.name.endswith("/manifest")]
keys = {a.name.split("/")[1]: json.loads(a.value) for a in manifests}
(key, names) = next(iter(keys.items()))
attribute = lambda what: spec.getattribute(f"cryptomatte/{key}/{what}")
assert attribute("name") == "CryptoObject" and attribute("conversion") == "uint32_to_float32", spec
assert "caustic_warm.R" in spec.channelnames and "albedo.G" in spec.channelnames, spec.channelnames
by_id = {int(value, 16): name for name, value in names.items()}
covered = {}
for level in range(6):
    layer, pair = f"CryptoObject{level // 2:02}", ("R", "G") if level % 2 == 0 else ("B", "A")
    ids, shares = (spec.channelnames.index(f"{layer}.{c}") for c in pair)
    for row in pixels:
        for pixel in row:
            if pixel[shares] > 0:
                name = by_id[struct.unpack("<I", struct.pack("<f", pixel[ids]))[0]]
                covered[name] = covered.get(name, 0) + float(pixel[shares])
print(json.dumps(covered))
