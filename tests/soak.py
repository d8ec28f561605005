"""Thousands of random landings against the independent solution: `python tests/soak.py 100000
[--from NUMBER] [--workers N]`.

Needs what the tests need: `pip install ".[dev]"`; exit code 2 where that is missing.

Ends with 1 if a reported bound was violated or a row was wrongly left out as dependent; the
offending numbers are printed. After an interrupt it says with which --from it continues.
"""

import argparse
import collections
import multiprocessing
import os
import signal
import sys
import time

# one thread for each process
os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")

try:
    from proof_check import check
except ModuleNotFoundError as missing:
    print(
        f"{missing.name} is not installed; in a clone of the repository: pip install '.[dev]'",
        file=sys.stderr,
    )
    sys.exit(2)

BLOCK = 20
"""Landings that a process takes at once."""


def main() -> int:
    options = argparse.ArgumentParser(
        description="Compare the package with an independent solution on random landings."
    )
    options.add_argument("count", type=int, nargs="?", default=100_000, help="landings [100000]")
    options.add_argument(
        "--from",
        dest="first",
        type=int,
        default=0,
        metavar="NUMBER",
        help="number of the first landing [0]",
    )
    options.add_argument(
        "--workers", type=int, default=os.cpu_count(), help="processes [one for each core]"
    )
    given = options.parse_args()
    numbers = range(given.first, given.first + given.count)
    refused, violated, largest, done, start = collections.Counter(), [], 0.0, 0, time.monotonic()
    # inherited: only this process answers Ctrl-C
    signal_of_parent = signal.signal(signal.SIGINT, signal.SIG_IGN)
    with multiprocessing.get_context("fork").Pool(given.workers) as pool:
        signal.signal(signal.SIGINT, signal_of_parent)
        try:
            for found in pool.imap(check, numbers, BLOCK):
                done += 1
                largest = max(largest, found.excess)
                if found.violated:
                    violated.append(found.number)
                    told = found.message or (
                        f"error / bound {found.excess:.3g}, dependent row missed by "
                        f"{found.missed:.1e}"
                    )
                    print(f"landing {found.number}: {told}")
                elif found.message:
                    refused[found.message.partition('"')[0].strip()] += 1
                if done % 1000 == 0:
                    rate = done / (time.monotonic() - start)
                    left = (given.count - done) / rate / 60.0
                    print(
                        f"{done} of {given.count}, {len(violated)} violations, {left:.0f} min left",
                        file=sys.stderr,
                        flush=True,
                    )
        except KeyboardInterrupt:
            print(f"interrupted; continue with: --from {given.first + done} {given.count - done}")
            pool.terminate()
    print(
        f"{done} landings: {done - refused.total()} solved, {refused.total()} refused, "
        f"{len(violated)} violations"
    )
    print(f"largest error / bound: {largest:.3g}")
    for message, times in refused.most_common():
        print(f"  refused {times} times: {message} …")
    return 1 if violated or done < given.count else 0


if __name__ == "__main__":
    sys.exit(main())
