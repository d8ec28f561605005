"""The law of elements of finite stiffness a second time: matrix exponentials in positions and
velocities, samples, bisection.
"""

import numpy as np
from scipy.linalg import expm

OPEN, LOADING, UNLOADING = range(3)


class Law:
    """Elements on a robot of inertia M that falls freely with accelerations g, and what each of
    them does; y = (x, ẋ, 1).
    """

    def __init__(self, M, elements, velocity, gravity):
        self.gravity = gravity
        self.steady = np.where(elements.stiffness > 0.0, 0.0, elements.load)
        self.el, self.n, self.inverse = elements, len(M), np.linalg.inv(M)
        self.size = np.sqrt(np.einsum("ri,ij,rj->r", elements.rows, self.inverse, elements.rows))
        self.speed = np.sqrt(velocity @ M @ velocity)
        self.y = np.concatenate([np.zeros(self.n), velocity, [1.0]])
        approaches = elements.contact[
            elements.normal & (elements.rows @ velocity < -1e-12 * self.size * self.speed)
        ]
        self.mode = np.where(
            (elements.contact < 0) | np.isin(elements.contact, approaches), LOADING, OPEN
        )
        self.slope = elements.stiffness.copy()
        self.slack, self.peak, self.way, self.opened = np.zeros((4, len(elements.rows)))
        sprung = elements.stiffness > 0.0
        self.slack[sprung] = (elements.load + 0.0 * self.slack)[sprung] / elements.stiffness[sprung]
        self.change()

    def change(self):
        """After an event: the system ẏ = A y, forces C x + d, held rows at rest, and the direction
        in which rows are loaded.
        """
        B, n, y = self.el.rows, self.n, self.y
        held = (self.mode == UNLOADING) & (self.el.restitution == 0.0)
        sprung = (self.mode != OPEN) & ~held
        self.C, self.d = (
            -(sprung * self.slope)[:, None] * B,
            sprung * self.slope * self.slack + self.steady,
        )
        if held.any():
            H, scale = B[held], 1.0 / self.size[held]
            weighted = (
                np.linalg.pinv(scale[:, None] * H @ self.inverse @ H.T * scale, rcond=1e-9)
                * scale
                * scale[:, None]
            )
            take = -weighted @ H @ self.inverse @ B.T
            self.C[held], self.d[held] = take @ self.C, take @ self.d - weighted @ H @ self.gravity
            y[n:-1] -= self.inverse @ H.T @ weighted @ H @ y[n:-1]
        self.A = np.zeros((2 * n + 1, 2 * n + 1))
        self.A[:n, n:-1] = np.eye(n)
        self.A[n:-1, :n], self.A[n:-1, -1] = (
            self.inverse @ B.T @ self.C,
            self.inverse @ B.T @ self.d + self.gravity,
        )
        rate, later = B @ y[n:-1], B @ (self.A @ y)[n:-1]
        first = np.where(np.abs(rate) > 1e-9 * self.size * self.speed, rate, later)
        self.way = np.where(
            self.el.normal,
            -1.0,
            np.where(self.way == 0.0, np.where(first < 0.0, -1.0, 1.0), self.way),
        )

    def force(self, y):
        """The forces of all elements."""
        return self.C @ y[: self.n] + self.d

    def signals(self, y):
        """What must not fall below −1e-10; what is held by no force is released: (value, element,
        event).
        """
        el, force, rate = (
            self.el,
            self.force(y),
            self.el.rows @ y[self.n : -1] / (self.size * self.speed),
        )
        stiffest = np.sqrt(el.stiffness.max())
        for i, mode in enumerate(self.mode):
            if mode == LOADING and (el.normal[i] or el.restitution[i] < 1.0):
                yield self.way[i] * rate[i], i, "unloads"
            elif mode == UNLOADING:
                along = (
                    (1.0 if el.normal[i] or self.peak[i] >= 0.0 else -1.0)
                    * force[i]
                    / (self.speed * stiffest)
                )
                yield along - (2e-10 if el.restitution[i] == 0.0 else 0.0), i, "released"
                yield abs(self.peak[i]) / (self.speed * stiffest) - along, i, "reloads"
            elif mode == OPEN and el.normal[i]:
                yield (
                    (el.rows[i] @ y[: self.n] - self.opened[i])
                    * stiffest
                    * self.size.max()
                    / (self.size[i] * self.speed),
                    i,
                    "closes",
                )

    def happen(self, i, kind):
        """Let an event happen to element i: loading has the slope k, unloading k/e² from the peak,
        to which it is loaded again.
        """
        el, place, force = self.el, self.el.rows @ self.y[: self.n], self.force(self.y)[i]
        k, rows = el.stiffness, el.contact == el.contact[i]
        if kind == "unloads":
            self.mode[i], self.peak[i] = UNLOADING, force
            if el.restitution[i] > 0.0:
                self.slope[i] = k[i] / el.restitution[i] ** 2
                self.slack[i] = place[i] + force / self.slope[i]
        elif kind == "reloads" or (kind == "released" and not el.normal[i]):
            again = kind == "reloads"
            self.mode[i], self.slope[i], self.slack[i] = (
                LOADING,
                k[i],
                place[i] + again * self.peak[i] / k[i],
            )
            self.way[i] = -again * np.sign(self.peak[i])
        elif kind == "released":
            tangents = rows & ~el.normal
            slips = el.restitution[i] == 0.0 and np.any(self.mode[tangents] != OPEN)
            self.mode[tangents if slips else rows], self.opened[i] = OPEN, place[i]
        else:
            self.mode[rows], self.slope[rows], self.slack[rows], self.way[rows] = (
                LOADING,
                k[rows],
                place[rows],
                0.0,
            )
        self.change()


def follow(M, elements, velocity, end, samples, gravity=0.0):
    """Times (T,), forces (T, r) and velocities (T, n) until an end."""
    law, t, step, rows = (
        Law(M, elements, velocity, gravity + 0.0 * velocity),
        0.0,
        end / samples,
        [],
    )
    while True:
        for _ in range(200):
            value, i, kind = min(law.signals(law.y))
            if value >= -1e-10:
                break
            law.happen(i, kind)
        else:
            raise AssertionError("events without end")
        rows.append((t, law.force(law.y), law.y[law.n : -1].copy()))
        if t >= end * (1.0 - 1e-12):
            return tuple(map(np.array, zip(*rows, strict=True)))
        forward = expm(law.A * step)
        while t < end * (1.0 - 1e-12):
            after = (forward if t + step <= end else expm(law.A * (end - t))) @ law.y
            if min(law.signals(after))[0] < -2e-10:
                low, high = 0.0, min(step, end - t)
                while high - low > 1e-13 * end:
                    middle = (low + high) / 2.0
                    early = min(law.signals(expm(law.A * middle) @ law.y))[0] >= -2e-10
                    low, high = (middle, high) if early else (low, middle)
                law.y, t = expm(law.A * high) @ law.y, t + high
                rows.append((t, law.force(law.y), law.y[law.n : -1].copy()))
                break
            law.y, t = after, min(t + step, end)
            rows.append((t, law.force(law.y), law.y[law.n : -1].copy()))
