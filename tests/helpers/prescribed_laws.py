"""The schemes of Chen et al. 2018 for one spacecraft, from the paper and its corrections, and a plant.

The inertia of the plant varies.

Nothing of the package is used. Bounds are plain numbers: rho0, rho_inf and kappa of Eq. (21), and the factors of Eq.
(23) as their final values, their common start (None: at the final values) and their common rate. Laws are called as
``law(time, q, w)`` once per control period and return the wheel torques.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from helpers.laws import kinematic_matrix, mrp, relative, rotation, sig, skew
from scipy.integrate import solve_ivp


@dataclass
class Bounds:
    rho0: float = 0.5
    rho_inf: float = 0.001
    kappa: float = 0.1
    lower: tuple = (0.8, 1.0, 0.2)
    upper: tuple = (0.2, 0.2, 0.8)
    start: float | None = 2.0
    rate: float = 5.0

    def rho(self, t):
        """Of real or complex time."""
        return (self.rho0 - self.rho_inf) * np.exp(-self.kappa * t) + self.rho_inf

    def factor(self, final, t):
        return final if self.start is None else final + (self.start - final) * np.exp(-self.rate * t)

    def flipped(self, axes):
        """Exchanged where ``axes`` is true."""
        low = tuple(u if flip else w for w, u, flip in zip(self.lower, self.upper, axes, strict=True))
        high = tuple(w if flip else u for w, u, flip in zip(self.lower, self.upper, axes, strict=True))
        return Bounds(self.rho0, self.rho_inf, self.kappa, low, high, self.start, self.rate)


def epsilon(bounds, axis, sigma, t, margin):
    """Eq. (24), and its tangent within ``margin`` of the bounds; sigma and t may be complex."""
    low, high = bounds.factor(bounds.lower[axis], t), bounds.factor(bounds.upper[axis], t)
    place = (low + sigma / bounds.rho(t)) / (low + high)
    edge = margin if place.real < margin else 1.0 - margin if place.real > 1.0 - margin else None
    if edge is None:
        return 0.5 * np.log((low + sigma / bounds.rho(t)) / (high - sigma / bounds.rho(t)))
    return 0.5 * np.log(edge / (1.0 - edge)) + (place - edge) / (2.0 * edge * (1.0 - edge))


def transformed(bounds, sigma, t, margin):
    """epsilon, r and theta (25), the last two by complex steps, which are exact to rounding."""
    tiny = 1e-30
    value = [epsilon(bounds, i, s, t, margin) for i, s in enumerate(sigma)]
    r = [epsilon(bounds, i, s + 1j * tiny, t, margin).imag / tiny for i, s in enumerate(sigma)]
    theta = [epsilon(bounds, i, s, t + 1j * tiny, margin).imag / tiny for i, s in enumerate(sigma)]
    return np.array(value), np.array(r), np.array(theta)


class Fuzzy:
    """Eqs. (18), (42), (45): seven Gaussians of width 1 on the diagonal of [-3, 3]."""

    def __init__(self, period, h=0.5, gain=2.0, leak=0.001):
        self.period, self.h, self.gain, self.leak, self.theta = period, h, gain, leak, 0.0

    def __call__(self, s, *inputs):
        x = np.concatenate(inputs)
        grades = [np.prod(np.exp(-((x - centre) ** 2))) for centre in range(-3, 4)]
        shares = np.array(grades) / sum(grades)
        square = sum(share * share for share in shares)
        part = self.theta * square * s / (2.0 * self.h**2)
        change = self.gain * square * (s @ s) / (2.0 * self.h**2) - self.leak * self.theta
        self.theta += self.period * change
        return part


class Lifted:
    """sigma on the short branch, or on the branch that it is on at the start (no shadow switch)."""

    def __init__(self, short):
        self.short, self.last = short, None

    def __call__(self, q):
        if self.short:
            return mrp(q)
        self.last = -q if self.last is not None and self.last @ q < 0.0 else q
        return self.last[1:] / (1.0 + self.last[0])


class Law:
    def __init__(self, model, **gains):
        self.model = model
        for name, value in {**self.GAINS, **gains}.items():
            setattr(self, name, value)
        self.started()

    def limited(self, torque):
        return np.clip(np.linalg.solve(self.model.axes, torque), -self.model.limits, self.model.limits)


class M1(Law):
    """Eqs. (21)-(45): ``substeps`` Euler steps of (30) and (33) with alpha, sigma and r held; None is x_c = alpha."""

    GAINS: ClassVar = {
        "k1": 0.1, "k2": 0.8, "tau1": 0.01, "tau2": 0.5, "gamma": 0.3, "l1": 0.01, "b1": 3.0, "b2": 4.0,
        "substeps": 1, "start": "zero", "bounds": Bounds(), "margin": 1e-4,
    }  # fmt: skip

    def started(self):
        self.fuzzy, self.xi = Fuzzy(self.model.period), np.zeros(3)
        self.phi1 = np.zeros(3) if self.start == "zero" else None
        self.phi2 = np.zeros(3)

    def __call__(self, time, q, w):
        sigma = mrp(q)
        z1, r, theta = transformed(self.bounds, sigma, time, self.margin)
        matrix = kinematic_matrix(sigma)
        s1 = z1 - self.xi
        alpha = np.linalg.inv(matrix) @ ((-self.k1 * z1 - self.tau1 * sig(s1, self.gamma) - theta) / r)
        if self.substeps is None:
            x_c, x_c_rate = alpha, np.zeros(3)
        else:
            self.phi1 = alpha if self.phi1 is None else self.phi1
            x_c, x_c_rate = self.phi1, self.filter_rate(alpha)
            h = self.model.period / self.substeps
            for _ in range(self.substeps):
                xi_rate = -self.k1 * self.xi + r * (matrix @ (self.phi1 - alpha)) - self.l1 * np.sign(self.xi)
                phi1_rate = self.filter_rate(alpha)
                self.phi2 = self.phi2 - h * self.b2 * np.sign(self.phi1 - alpha)
                self.phi1, self.xi = self.phi1 + h * phi1_rate, self.xi + h * xi_rate
        s2 = w - x_c
        wanted = -self.k2 * s2 - self.fuzzy(s2, w, x_c, x_c_rate) - self.tau2 * sig(s2, self.gamma)
        self.seen = {"epsilon": z1, "alpha": alpha, "s2": s2}
        return self.limited(self.model.inertia @ wanted)

    def filter_rate(self, alpha):
        return -self.b1 * sig(self.phi1 - alpha, 0.5) + self.phi2


class M2(Law):
    """Eqs. (64)-(66) with z2 for s2."""

    GAINS: ClassVar = {"k1": 0.1, "k2": 0.8, "short": True}

    def started(self):
        self.fuzzy, self.branch = Fuzzy(self.model.period), Lifted(self.short)

    def __call__(self, time, q, w):
        sigma = self.branch(q)
        alpha = -self.k1 * np.linalg.inv(kinematic_matrix(sigma)) @ sigma
        z2 = w - alpha
        self.seen = {"s2": z2}
        return self.limited(self.model.inertia @ (-self.k2 * z2 - self.fuzzy(z2, w, alpha)))


class M3(Law):
    """Eqs. (67)-(71), with and without the second term of (70)."""

    GAINS: ClassVar = {
        "k1": 0.4, "k2": 0.2, "r": 9 / 11, "small": 0.01, "tau": 10.0, "rho": 1.0, "o": 0.1, "p": 2.0,
        "layer": 1e-4, "jump": False, "short": True,
    }  # fmt: skip

    def started(self):
        self.c, self.branch = np.zeros(3), Lifted(self.short)

    def bent(self, x):
        """S_au of one component."""
        r, e = self.r, self.small
        if abs(x) >= e:
            return np.sign(x) * abs(x) ** r
        return (2.0 - r) * e ** (r - 1.0) * x + (r - 1.0) * e ** (r - 2.0) * np.sign(x) * x * x

    def __call__(self, time, q, w):
        sigma = self.branch(q)
        s = w + self.k1 * sigma + self.k2 * np.array([self.bent(x) for x in sigma])
        size, speed = np.linalg.norm(s), np.linalg.norm(w)
        f = self.c[0] + self.c[1] * speed + self.c[2] * speed**2
        if size * f > self.layer:
            v_ss = s / size * f
            if self.jump:
                v_ss = v_ss + s / size**2 * sum(self.o / (4.0 * self.p) * c for c in self.c)
        else:
            v_ss = s / self.layer * f**2
        growth = np.array([size, size * speed, size * speed**2])
        self.c = self.c + self.model.period * (-self.o * self.c + self.p * growth)
        self.seen = {"s2": s, "outside": size * f > self.layer}
        return self.limited(-self.tau * s - self.rho * sig(s, 0.5) - v_ss)


class Sampled(Law):
    """prescribed_performance: w_e' = -k2 s - tau2 sig(s)^gamma, with the gyroscopic torque and the reference's motion.

    The gyroscopic torque is known to the law only where the wheels store no momentum that acts on the body.
    """

    GAINS: ClassVar = {
        "k1": 0.05, "k2": 2.0, "tau2": 1e-3, "gamma": 0.3, "margin": 0.05,
        "bounds": Bounds(1.5, 1e-3, 0.04, (1.0,) * 3, (1.0,) * 3, None),
    }  # fmt: skip

    def started(self):
        pass

    def __call__(self, time, q, w):
        model = self.model
        target, target_rate, target_acceleration = model.target.body(time)
        error = relative(q, target)
        turn, sigma = rotation(-error if error[0] < 0.0 else error), mrp(error)
        w_e = w - turn @ target_rate
        z1, r, theta = transformed(self.bounds, sigma, time, self.margin)
        alpha = np.linalg.inv(kinematic_matrix(sigma)) @ np.linalg.inv(np.diag(r)) @ (-self.k1 * z1 - theta)
        s = w_e - alpha
        wanted = -self.k2 * s - self.tau2 * sig(s, self.gamma)
        wanted = wanted + turn @ target_acceleration - skew(w_e) @ (turn @ target_rate)
        self.seen = {"epsilon": z1, "s2": s}
        command = model.minimax(model.inertia @ wanted + model.gyroscopic(w))
        return command / max(1.0, (np.abs(command) / model.limits).max())


class VaryingPlant:
    """J(t) w' = -w x J(t) w [- J' w] + D E(t) sat(v) + d(t, w), integrated by DOP853 from sample to sample.

    ``inertia``, ``inertia_rate`` and ``effectiveness(t, probe)`` are functions of time; ``probe``, a time within the
    period, decides which faults act. ``inertia_rate=None`` leaves -J' w out, as the paper does.
    """

    def __init__(self, model, inertia, inertia_rate, effectiveness, external):
        self.model, self.inertia, self.inertia_rate = model, inertia, inertia_rate
        self.effectiveness, self.external = effectiveness, external

    def derivative(self, time, state, command, probe):
        q, w = state[:4], state[4:]
        matrix, across = self.inertia(time), skew(w)
        torque = self.model.axes @ (self.effectiveness(time, probe) * command) + self.external(time, w)
        torque = torque - across @ (matrix @ w)
        if self.inertia_rate is not None:
            torque = torque - self.inertia_rate(time) @ w
        turn = 0.5 * np.append(-q[1:] @ w, q[0] * w - across @ q[1:])
        return np.append(turn, np.linalg.solve(matrix, torque))

    def history(self, law, state, steps):
        """States (steps + 1, 7) and commands (steps, wheels)."""
        period, states, commands = self.model.period, [np.array(state)], []
        for step in range(steps):
            time = step * period
            commands.append(law(time, states[-1][:4], states[-1][4:]))
            options = {"rtol": 1e-11, "atol": 1e-13, "first_step": 0.999 * period, "t_eval": [time + period]}
            span, arguments = (time, time + period), (commands[-1], time + 0.5 * period)
            solution = solve_ivp(self.derivative, span, states[-1], "DOP853", args=arguments, **options)
            states.append(solution.y[:, -1])
        return np.array(states), np.array(commands)
