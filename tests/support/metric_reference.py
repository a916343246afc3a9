#!/usr/bin/env python3
"""Prints the reference numbers of tests/fast/metric.rs.

Independent implementations: scikit-image 0.26.0 (SSIM) and flip-evaluator 1.7 (LDR FLIP), both from PyPI, and numpy
for the rest. The two pictures are given by integer formulas, so both sides have the same bits.

    pip install scikit-image flip-evaluator && python3 tests/support/metric_reference.py
"""
import flip_evaluator
import numpy as np
from skimage.metrics import structural_similarity

W, H = 61, 43
y, x, c = np.meshgrid(np.arange(H), np.arange(W), np.arange(3), indexing="ij")
reference = ((x * (c + 1) + 3 * y) % 65) / 64
test = reference + ((x * y + 7 * c) % 9 - 4) / 64


def encode(v):
    v = np.clip(v, 0, 1)
    return np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)


def ssim(a, b):
    return structural_similarity(
        a, b, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1, channel_axis=2
    )


d = test - reference
per_pixel = np.sort((d**2 / (reference**2 + 0.01)).mean(axis=2).ravel())
kept = per_pixel[: W * H - int(0.001 * W * H)]
as8 = lambda v: (np.round(encode(v) * 255) / 255).astype(np.float32)
print("mae", np.abs(d).mean())
print("rmse", np.sqrt((d**2).mean()))
print("bias", d.mean())
print("max_error", np.abs(d).max())
print("rel_mse", per_pixel.mean())
print("rel_mse_trimmed", kept.mean())
print("ssim srgb", ssim(encode(reference), encode(test)))
print("ssim linear", ssim(np.clip(reference, 0, 1), np.clip(test, 0, 1)))
print("flip", flip_evaluator.evaluate(as8(reference), as8(test), "LDR", applyMagma=False)[1])
