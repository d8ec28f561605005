"""A random permutation of any size, of which some places are computed without the others."""

import numpy as np


def permuted(n: int, rows: np.ndarray, seed: int, number: int) -> np.ndarray:
    """The places of some rows in a random permutation of all n, in which each chunk of the strata
    of a sample is computed alone.

    A Feistel network permutes the numbers of 2 b bits, at least n of them; a number that leaves [0,
    n) is permuted until it comes back (Black and Rogaway 2002, "Ciphers with arbitrary finite
    domains").

    Args:
        n: number of rows.
        rows: (m,) their numbers.
        seed: of the random numbers.
        number: of the quantity, each of which has another permutation.
    """
    bits = np.uint64(max(1, -(-(n - 1).bit_length() // 2)))
    low = np.uint64((1 << int(bits)) - 1)
    keys = np.random.default_rng([seed, 3, number]).integers(2**64, size=8, dtype=np.uint64)
    out, outside = rows.astype(np.uint64), np.ones(len(rows), dtype=bool)
    while outside.any():
        left, right = out[outside] >> bits, out[outside] & low
        for key in keys:
            # The mixing function of splitmix64 (Steele, Lea and Flood 2014).
            x = right + key
            x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
            x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
            left, right = right, left ^ ((x ^ (x >> np.uint64(31))) & low)
        out[outside] = left << bits | right
        outside = out >= n
    return out.astype(np.int64)
