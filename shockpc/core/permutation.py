"""A random permutation of any size, of which some places are computed without the others."""

import numpy as np


def permuted(n: int, rows: np.ndarray, seed: int, number: int) -> np.ndarray:
    """The places of some rows in a random permutation of all n.

    With them each chunk of the strata of a sample is computed alone.

    A Feistel network permutes the numbers of 2 b bits, at least n of them; a number that leaves [0,
    n) is permuted until it comes back (Black and Rogaway 2002, "Ciphers with arbitrary finite
    domains").

    Args:
        n: number of rows.
        rows: (m,) their numbers.
        seed: of the random numbers.
        number: of the quantity, each of which has another permutation.
    """
    half_bits = max(1, -(-(n - 1).bit_length() // 2))
    bits = np.uint64(half_bits)
    low = np.uint64((1 << half_bits) - 1)
    rng = np.random.default_rng([seed, 3, number])
    keys = rng.integers(2**64, size=8, dtype=np.uint64)
    out = rows.astype(np.uint64)
    outside = np.ones(len(rows), dtype=bool)
    while outside.any():
        left = out[outside] >> bits
        right = out[outside] & low
        for key in keys:
            left, right = right, left ^ (_mixed(right + key) & low)
        out[outside] = left << bits | right
        outside = out >= n
    return out.astype(np.int64)


def _mixed(x: np.ndarray) -> np.ndarray:
    """The mixing function of splitmix64 (Steele, Lea and Flood 2014) of numbers of 64 bits."""
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.asarray(x ^ (x >> np.uint64(31)))
