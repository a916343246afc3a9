#!/usr/bin/env python3
"""Prints the reference numbers of tests/fast/metric.rs.

Independent implementations: scikit-image 0.26.0 (SSIM) and flip-evaluator 1.7 (LDR and HDR FLIP), both from PyPI, and
numpy for the rest. All pictures are given by integer formulas, so both sides have the same bits.

    pip install scikit-image flip-evaluator && python3 tests/support/metric_reference.py
"""
import flip_evaluator
import numpy as np
from skimage.metrics import structural_similarity


def pictures(width, height, amount=1):
    """Reference and test in units of 1/64: a pattern, and the same with noise."""
    y, x, c = np.meshgrid(np.arange(height), np.arange(width), np.arange(3), indexing="ij")
    reference = (x * (c + 1) + 3 * y) % 65
    return reference, reference + amount * ((x * y + 7 * c) % 9 - 4)


def bright(n, squarings, gain):
    """Linear light up to `gain` and more, darker in the middle the more often it is squared, as f32."""
    v = np.maximum(n, 0) / 64
    for _ in range(squarings):
        v = v * v
    return (v * gain).astype(np.float32)


def encode(v):
    v = np.clip(v, 0, 1)
    return np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)


def as8(v):
    return (np.round(encode(v) * 255) / 255).astype(np.float32)


def ssim_map(a, b):
    """Of the positions where the whole window lies inside, mean over the colours, without the border of five pixels."""
    full = structural_similarity(
        a, b, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1, channel_axis=2, full=True
    )[1]
    return full.mean(axis=2)[5:-5, 5:-5]


def flip_map(a, b):
    return flip_evaluator.evaluate(as8(a), as8(b), "LDR", applyMagma=False)[0][:, :, 0]


def hdr_map(a, b):
    found = flip_evaluator.evaluate(a.astype(np.float32), b.astype(np.float32), "HDR", applyMagma=False)
    return found[0][:, :, 0], found[2]


def tone(x):
    """The curve ACES of flip-evaluator."""
    curve = (0.36 * 2.51 * x * x + 0.6 * 0.03 * x) / (0.36 * 2.43 * x * x + 0.6 * 0.59 * x + 0.14)
    return np.clip(curve, 0, 1)


def hdr_map_of_8_bits(a, b, said):
    """The same with pictures of eight bits at each exposure, which is what nv-flip takes."""
    stops = np.linspace(said["startExposure"], said["stopExposure"], said["numExposures"])
    return np.max([flip_map(*(tone(v.astype(float) * 2**stop) for v in (a, b))) for stop in stops], axis=0)


def rms(v):
    return np.sqrt((v**2).mean())


W, H = 61, 43
reference, test = (n / 64 for n in pictures(W, H))
d = test - reference
per_pixel = np.sort((d**2 / (reference**2 + 0.01)).mean(axis=2).ravel())
kept = per_pixel[: W * H - int(0.001 * W * H)]
print("mae", np.abs(d).mean())
print("rmse", rms(d))
print("bias", d.mean())
print("max_error", np.abs(d).max())
print("rel_mse", per_pixel.mean())
print("rel_mse_trimmed", kept.mean())
print("ssim srgb", ssim_map(encode(reference), encode(test)).mean())
print("ssim linear", ssim_map(np.clip(reference, 0, 1), np.clip(test, 0, 1)).mean())
print("flip", flip_map(reference, test).mean(dtype=float))

print("\nHDR: width, height, noise, squarings, gain, start, stop, number, mean, mean of 8 bits")
HDR = [
    (61, 43, 1, 0, 4),
    (61, 43, 1, 2, 16),
    (64, 48, 2, 2, 16),
    (64, 48, 1, 3, 4096),
    (97, 30, 3, 1, 0.25),
    (30, 97, 4, 3, 100),
]
for width, height, amount, squarings, gain in HDR:
    a, b = (bright(n, squarings, gain) for n in pictures(width, height, amount))
    values, said = hdr_map(a, b)
    exposures = [round(float(said[name]), 5) for name in ("startExposure", "stopExposure")]
    means = [float(v.mean(dtype=float)) for v in (values, hdr_map_of_8_bits(a, b, said))]
    print((width, height, amount, squarings, gain, *exposures, said["numExposures"], *means))

# A study's judgement: values in units of `white`, where `mask` holds; elsewhere both pictures are the same.
WHITE = 0.375
a, b = ((v / WHITE).astype(np.float32).astype(float) for v in (reference, np.maximum(test, 0)))
whole = np.ones((H, W), bool)
region = np.zeros((H, W), bool)
region[8:36, 12:40] = True
y, x = np.mgrid[:H, :W]
patch = region & ((x + 2 * y) % 5 > 0)
for name, mask in (("whole", whole), ("region", region), ("region and mask", patch)):
    patched = np.where(mask[:, :, None], b, a)
    shown = [np.clip(v, 0, 1) for v in (a, patched)]
    difference = (patched - a)[mask]
    print(f"\n{name}, white {WHITE}")
    print("rmse shown", rms((shown[1] - shown[0])[mask]))
    print("rmse linear", rms(difference))
    print("rel_mse", (difference**2 / (a[mask] ** 2 + 0.01)).mean())
    print("mae", np.abs(difference).mean())
    print("ssim linear", ssim_map(*shown)[mask[5:-5, 5:-5]].mean())
    print("ssim srgb", ssim_map(*map(encode, shown))[mask[5:-5, 5:-5]].mean())
    print("flip", flip_map(a, patched)[mask].mean(dtype=float))
    print("flip hdr", hdr_map(a, patched)[0][mask].mean(dtype=float))
