"""The laws of Ma, Wang and Wang 2023 for one spacecraft, written out from the paper with matrices.

Each is called as ``law(time, q, w, last command)``, like those of ``helpers.controllers``, and returns the
wheel command. Between two samples the measurement is held. The adaptive gain of HSFC then changes
exponentially, the bounds of AFNTSMC move by one Euler step, and the filter of SHOPD+ decays exactly.
"""

import numpy as np
from helpers.laws import IDENTITY, relative, sig, skew
from scipy.integrate import solve_ivp


def kinematics(q, w):
    """Eqs. (1), (7), scalar first."""
    return 0.5 * np.append(-q[1:] @ w, (q[0] * IDENTITY + skew(q[1:])) @ w)


class RateTarget:
    """A reference whose rate in its own axes is given: constant + amplitude sin(frequency t + phase)."""

    def __init__(self, amplitude, frequency, constant=(0.0, 0.0, 0.0), phase=(0.0, 0.0, 0.0), attitude=(1.0, 0, 0, 0)):
        self.amplitude, self.frequency, self.phase = map(np.array, (amplitude, frequency, phase))
        self.constant, self.attitude, self.path = np.array(constant), np.array(attitude), None

    def motion(self, time):
        """w_d and w_d'."""
        angle = self.frequency * time + self.phase
        return self.constant + self.amplitude * np.sin(angle), self.amplitude * self.frequency * np.cos(angle)

    def body(self, time):
        """q_d, w_d and w_d', within the first ten seconds."""
        if self.path is None:
            options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13, "max_step": 0.1, "dense_output": True}
            derivative = lambda t, q: kinematics(q, self.motion(t)[0])  # noqa: E731
            self.path = solve_ivp(derivative, (0.0, 10.0), self.attitude, **options).sol
        return self.path(time), *self.motion(time)


class Hybrid:
    """Common parts of the three: the error, Eqs. (8)-(10), and h, Eqs. (13), (15), (16)."""

    def __init__(self, model, eta):
        self.model, self.eta = model, eta
        self.h, self.jumps, self.seen = 1.0, 0, None

    def errors(self, reference, q, w):
        """e_v, e_4, w_e and (C w_d) x J C w_d + J C w_d'."""
        attitude, rate, acceleration = reference
        error = relative(q, attitude)
        if self.seen is not None and np.linalg.norm(error - self.seen) > np.linalg.norm(error + self.seen):
            error = -error
        self.seen = error
        e4, ev, inertia = error[0], error[1:], self.model.inertia
        matrix = (e4**2 - ev @ ev) * IDENTITY + 2.0 * np.outer(ev, ev) - 2.0 * e4 * skew(ev)
        turned = matrix @ rate
        return ev, e4, w - turned, skew(turned) @ inertia @ turned + inertia @ matrix @ acceleration

    def jump(self, e4):
        if self.eta is not None and self.h * e4 <= -self.eta:
            self.h, self.jumps = -self.h, self.jumps + 1

    def wheels(self, torque):
        """Three wheels are clipped one by one; of more, all are scaled alike."""
        axes, limits = self.model.axes, self.model.limits
        if axes.shape[1] == 3:
            return np.clip(np.linalg.inv(axes) @ torque, -limits, limits)
        command = self.model.minimax(torque)
        return command / max(1.0, (np.abs(command) / limits).max())

    def __call__(self, time, q, w, last):
        ev, e4, we, feed = self.errors(self.model.target.body(time), q, w)
        self.jump(e4)
        return self.wheels(self.torque(ev, e4, w, we, feed))


class HSFC(Hybrid):
    """Eqs. (14), (17)-(20), (43)."""

    def __init__(self, model, form="norm", k=5.0, k1=5.0, alpha=0.01, delta=0.05, gamma0=0.2, layer=0.005, gamma=2.5,
                 floor=0.0, eta=0.1):  # fmt: skip
        super().__init__(model, eta)
        self.form, self.k, self.k1, self.alpha, self.delta, self.gamma0 = form, k, k1, alpha, delta, gamma0
        self.layer, self.gamma, self.floor, self.history = layer, gamma, floor, []

    def w(self, x):
        """Eq. (43), component by component; the sign without a layer."""
        if self.layer == 0.0:
            return np.sign(x)
        return np.array([xi / abs(xi) if abs(xi) > self.layer else xi / self.layer for xi in x])

    def demanded(self, ev, e4, we, feed):
        """u and gamma'/gamma."""
        g2, h = self.gamma**2, self.h
        s = we + h * g2 * ev
        u1 = np.array([-self.k * s[i] / (abs(s[i]) + g2 * self.delta) + feed[i] for i in range(3)])
        size = {
            "norm": np.linalg.norm(u1) * np.ones(3), "sliding": np.linalg.norm(u1) * np.ones(3),
            "componentwise": np.abs(u1),
        }[self.form]  # fmt: skip
        u2 = -(1.0 - self.gamma0) / self.gamma0 * np.diag(size) @ self.w(s if self.form == "sliding" else we)
        total = 0.0
        for i in range(3):
            total += h * ev[i] * we[i] / (abs(s[i]) + g2 * self.delta)
            total -= abs(we[i]) * (1.0 + self.delta) / (abs(we[i]) + g2 * (1.0 + self.delta))
        bracket = self.k * total - 0.5 * self.k1 * h * ev @ s
        return u1 + u2, self.alpha / (1.0 + 2.0 * self.alpha * self.k1 * (1.0 - h * e4)) * bracket

    def torque(self, ev, e4, w, we, feed):
        u, growth = self.demanded(ev, e4, we, feed)
        self.history.append(self.gamma)
        self.gamma = max(self.gamma * np.exp(growth * self.model.period), self.floor)
        return u


class AFNTSMC(Hybrid):
    """Eqs. (45)-(52); with an eta, of h e_v instead of e_v."""

    def __init__(self, model, tau=20.0, beta=10.0, chi=0.5, k2=1.0, k3=1.0, nu=0.6, epsilon=1e-3, e3=0.35, e5=0.16,
                 n=6.0, start=0.1, eta=None):  # fmt: skip
        super().__init__(model, eta)
        self.tau, self.beta, self.chi, self.k2, self.k3, self.nu = tau, beta, chi, k2, k3, nu
        self.epsilon, self.e3, self.e5, self.n = epsilon, e3, e5, n
        self.psi, self.phi = np.full(3, start), np.full(3, start)

    def surface(self, e):
        """Eq. (47) for one component, outside of the case that sampled spacecraft never meet."""
        if abs(e) >= self.epsilon:
            return np.sign(e) * abs(e) ** self.nu
        first = (2.0 - self.nu) * self.epsilon ** (self.nu - 1.0)
        second = (self.nu - 1.0) * self.epsilon ** (self.nu - 2.0)
        return first * e + second * np.sign(e) * e**2

    def torque(self, ev, e4, w, we, feed):
        turned = self.h * ev
        s = we + self.k2 * turned + self.k3 * np.array([self.surface(e) for e in turned])
        xi = max(np.linalg.norm(w) ** 2, np.linalg.norm(w))
        chi = 0.5 * self.psi / self.e5**2 + 0.5 * self.phi * xi**2 / self.e5**2
        psi = -self.e3 * self.psi + 0.5 * self.n * s**2 / self.e5**2
        phi = -self.e3 * self.phi + 0.5 * self.n * s**2 * xi**2 / self.e5**2
        self.psi, self.phi = self.psi + self.model.period * psi, self.phi + self.model.period * phi
        return -(self.tau * IDENTITY + np.diag(chi)) @ s - self.beta * sig(s, self.chi)


class SHOPD(Hybrid):
    """Eqs. (53)-(55): q_c decays towards -B e_v, which is held between two samples."""

    def __init__(self, model, matched=True, k4=30.0, k5=8.0, a=1.0, b=3.0, eta=0.1):
        super().__init__(model, eta)
        self.matched, self.k4, self.k5, self.a, self.b = matched, k4, k5, a, b
        self.qc = None

    def torque(self, ev, e4, w, we, feed):
        if self.qc is None:
            self.qc = -self.b * ev if self.matched else np.zeros(3)
        nu = self.qc + self.b * ev
        held = np.array([np.sign(n) if abs(n) >= 1.0 else n for n in nu])
        self.qc = -self.b * ev + (self.qc + self.b * ev) * np.exp(-self.a * self.model.period)
        return -self.k4 * self.h * ev - self.k5 * (e4 * IDENTITY + skew(ev)).T @ held + feed
