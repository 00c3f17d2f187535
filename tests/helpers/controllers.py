"""The controllers of two papers for one spacecraft, from the equations: command, sliding variable, its derivative.

Each law has ``state(time, q, w)``, which returns s, its designed derivative on the nominal plant without faults, and
the torque on the body that the law asks for; and is called as ``law(time, q, w, last command)``.
"""

from typing import ClassVar

import numpy as np
from helpers.laws import Perfect, kinematic_matrix, kinematic_matrix_rate, mrp, relative, rotation, sig, sign


def exponential(s, e1, e2, layer, floor=0.5, steepness=5.0):
    """Eqs. (35), (66)."""
    return -e1 * s - e2 / (floor + (1.0 - floor) * np.exp(-steepness * np.abs(s))) * sign(s, layer)


def parabola(x, r, mu):
    """S and S' of Eqs. (64), (65), from the two conditions at mu solved as a linear system."""
    c1, c2 = np.linalg.solve([[mu, mu**2], [1.0, 2.0 * mu]], [mu**r, r * mu ** (r - 1.0)])
    size = np.maximum(np.abs(x), 1e-300)
    outside = size >= mu
    value = np.where(outside, sig(x, r), c1 * x + c2 * x * np.abs(x))
    return value, np.where(outside, r * size ** (r - 1.0), c1 + 2.0 * c2 * np.abs(x))


class Controller:
    def __init__(self, model, observer=None, **gains):
        self.model, self.observer = model, observer or Perfect(model)
        for name, value in {**self.GAINS, **gains}.items():
            setattr(self, name, value)

    def __call__(self, time, q, w, last):
        torque = self.state(time, q, w)[2]
        self.observer.update(w, last)
        self.adapt(time, q, w)
        return np.clip(self.to_wheels(torque), -self.model.limits, self.model.limits)

    def adapt(self, time, q, w):
        pass


class ZhangZhou(Controller):
    """Network and allocation of both laws of Zhang and Zhou."""

    def __init__(self, model, observer=None, **gains):
        super().__init__(model, observer, **gains)
        self.weights = np.zeros((5, 3))

    def network(self, w):
        """Phi of Eq. (25)."""
        return np.array([np.exp(-np.sum((w - c) ** 2)) for c in (-1.0, -0.5, 0.0, 0.5, 1.0)])

    def train(self, s, w):
        self.weights = self.weights + self.model.period * self.network_gain * np.outer(
            self.network(w), self.model.inverse.T @ s
        )

    def to_wheels(self, torque):
        known = torque - self.model.axes @ self.observer.bias
        return self.model.spread(known, self.observer.effectiveness, 2.0)

    def torque(self, w, acceleration):
        return self.model.inertia @ acceleration + self.model.gyroscopic(w) - self.weights.T @ self.network(w)


class Stabilisation(ZhangZhou):
    """Eqs. (29)-(42)."""

    GAINS: ClassVar = {
        "linear": 0.6, "terminal": 0.6, "exponent": 5 / 7, "rate_bound_gain": 0.01, "fault_bound_gain": 0.001,
        "network_gain": 1.0, "reaching_linear": 1.5, "reaching_switching": 1.5, "layer": 0.05,
    }  # fmt: skip
    chi = rho = 0.0

    def errors(self, q, w):
        sigma = mrp(q)
        return sigma, kinematic_matrix(sigma) @ w, w + self.linear * sigma + self.terminal * sig(sigma, self.exponent)

    def state(self, time, q, w):
        sigma, turning, s = self.errors(q, w)
        robust = self.chi * np.linalg.norm(turning) + self.rho * self.model.norms
        wanted = exponential(s, self.reaching_linear, self.reaching_switching, self.layer)
        wanted = wanted - robust * sign(s, self.layer)
        left = self.linear * turning + self.terminal * self.exponent * np.abs(sigma) ** (self.exponent - 1.0) * turning
        unknown = self.model.inverse @ (self.weights.T @ self.network(w))
        return s, wanted - unknown + left, self.torque(w, wanted)

    def adapt(self, time, q, w):
        _, turning, s = self.errors(q, w)
        h, distance = self.model.period, np.linalg.norm(s)
        self.chi += h * self.rate_bound_gain * distance * np.linalg.norm(turning)
        self.rho += h * self.fault_bound_gain * distance * self.model.norms
        self.train(s, w)


class Tracking(ZhangZhou):
    """Eqs. (56)-(76) with the corrections of the paper's page."""

    GAINS: ClassVar = {
        "virtual_gain": 0.6, "linear": 0.6, "terminal": 0.6, "exponent": 5 / 7, "bound": 0.05, "feed_forward": False,
        "bound_gain": 0.01, "network_gain": 1.0, "coupling_gain": 0.01, "coupling_high": 0.02, "coupling_low": 0.01,
        "smallest_eta": 1e-3, "reaching_linear": 1.5, "reaching_switching": 1.5, "layer": 0.05,
    }  # fmt: skip
    omega, eta = 0.0, 1.0

    def errors(self, time, q, w):
        sigma, (target, first, second), c = mrp(q), self.model.target.mrp(time), self.virtual_gain
        matrix = kinematic_matrix(sigma)
        inverse = np.linalg.inv(matrix)
        z1 = sigma - target
        virtual = inverse @ (first - c * z1)
        z1_rate = matrix @ w - first
        turned = kinematic_matrix_rate(sigma, matrix @ w)
        change = inverse @ (second - c * z1_rate - turned @ virtual)
        z2 = w - virtual
        value, slope = parabola(z1, self.exponent, self.bound)
        coupling = abs(z1 @ matrix @ z2)
        return z1_rate, change, slope, coupling, z2 + self.linear * z1 + self.terminal * value

    def state(self, time, q, w):
        z1_rate, change, slope, coupling, s = self.errors(time, q, w)
        robust = exponential(s, self.reaching_linear, self.reaching_switching, self.layer)
        robust = robust - self.omega * sign(s, self.layer)
        robust = robust - s * (1.0 + self.eta) * coupling / (s @ s + self.coupling_low)
        known = self.terminal * slope * z1_rate
        wanted = robust + change - self.linear * z1_rate - (known if self.feed_forward else 0.0)
        left = 0.0 if self.feed_forward else known
        unknown = self.model.inverse @ (self.weights.T @ self.network(w))
        return s, robust + left - unknown, self.torque(w, wanted)

    def adapt(self, time, q, w):
        _, _, _, coupling, s = self.errors(time, q, w)
        h, square = self.model.period, s @ s
        self.omega += h * self.bound_gain * np.sqrt(square)
        slope = (self.eta * square - self.coupling_high) / (square + self.coupling_low) * coupling / self.eta
        self.eta = max(self.eta + h * self.coupling_gain * slope, self.smallest_eta)
        self.train(s, w)


def predefined(energy, h, time, regular=0.0):
    """The gain exp(V^h) V^-h / (2 h T) and its derivative with respect to V."""
    shifted = energy + regular
    gain = np.exp(energy**h) * shifted**-h / (2.0 * h * time)
    return gain, gain * (h * energy ** (h - 1.0) - h / shifted)


class PTC(Controller):
    """Eqs. (24)-(26) of Cao, Gong and Han."""

    GAINS: ClassVar = {
        "position_exponent": 0.25, "rate_exponent": 0.3, "position_time": 10.0, "rate_time": 10.0,
        "switching_gain": 5.0, "switching_form": "torque", "layer": 0.0,
    }  # fmt: skip

    def state(self, time, q, w):
        sigma, (target, first, second) = mrp(q), self.model.target.mrp(time)
        matrix = kinematic_matrix(sigma)
        z1, z2 = sigma - target, matrix @ w - first
        gain, slope = predefined(0.5 * z1 @ z1, self.position_exponent, self.position_time)
        s = z2 + gain * z1
        xi_rate = gain * z2 + slope * (z1 @ z2) * z1
        reaching = predefined(0.5 * s @ s, self.rate_exponent, self.rate_time)[0] * s
        switched = self.switching_gain * sign(s, self.layer)
        to_torque = self.model.inertia @ np.linalg.inv(matrix)
        turned = kinematic_matrix_rate(sigma, matrix @ w) @ w
        torque = self.model.gyroscopic(w) - to_torque @ (turned - second + xi_rate + reaching)
        if self.switching_form == "torque":
            return s, -reaching - matrix @ self.model.inverse @ switched, torque - switched
        return s, -reaching - switched, torque - to_torque @ switched

    def to_wheels(self, torque):
        known = torque - self.model.axes @ self.observer.bias
        return np.linalg.pinv(self.model.axes @ np.diag(np.maximum(self.observer.effectiveness, 0.05))) @ known


class Relative(Controller):
    """Laws in the error MRP: the subclass says what s, s' and w_e' are."""

    def state(self, time, q, w):
        target, target_rate, target_acceleration = self.model.target.body(time)
        error = relative(q, target)
        turn = rotation(error)
        sigma, w_e = mrp(error), w - turn @ target_rate
        s, designed, acceleration = self.design(sigma, w_e)
        moving = turn @ target_acceleration - np.cross(w_e, turn @ target_rate)
        return s, designed, self.model.inertia @ (acceleration + moving) + self.model.gyroscopic(w)

    def to_wheels(self, torque):
        model, seen = self.model, self.observer
        needed = torque - model.axes @ seen.bias - seen.disturbance
        command = model.minimax(needed)
        missing = needed - model.axes @ (seen.effectiveness * command)
        command = command + model.spread(missing, np.maximum(seen.effectiveness, 0.05), 1.0)
        return command / max(1.0, (np.abs(command) / model.limits).max())


class TSMC(Relative):
    GAINS: ClassVar = {
        "linear": 0.3, "terminal": 0.3, "exponent": 5 / 7, "guard": 0.02, "reaching_linear": 1.0,
        "reaching_power_gain": 0.2, "reaching_exponent": 0.5,
    }  # fmt: skip

    def design(self, sigma, w):
        p, speed = self.exponent, kinematic_matrix(sigma) @ w
        s = w + self.linear * sigma + self.terminal * sig(sigma, p)
        reaching = -self.reaching_linear * s - self.reaching_power_gain * sig(s, self.reaching_exponent)
        true = self.terminal * p * np.abs(sigma) ** (p - 1.0) * speed
        guarded = self.terminal * p * np.maximum(np.abs(sigma), self.guard) ** (p - 1.0) * speed
        return s, reaching + true - guarded, reaching - self.linear * speed - guarded


class NFTSM(Relative):
    GAINS: ClassVar = {
        "linear": 0.05, "terminal": 0.15, "exponent": 0.6, "bound": 1e-3, "reaching_linear": 1.0,
        "reaching_switching": 0.005, "rate_gain": 4.0,
    }  # fmt: skip

    def design(self, sigma, w):
        n, speed = np.linalg.norm(sigma), kinematic_matrix(sigma) @ w
        value, slope = parabola(n, self.exponent, self.bound)
        c, c_slope = self.linear * n + self.terminal * value, self.linear + self.terminal * slope
        axis = sigma / n
        n_rate = axis @ speed
        s = w + c * axis
        layer = self.reaching_switching / (self.rate_gain - self.reaching_linear)
        reaching = exponential(s, self.reaching_linear, self.reaching_switching, layer)
        axis_rate = (speed - n_rate * axis) / n
        return s, reaching, reaching - c_slope * n_rate * axis - c * axis_rate


class PredefinedTime(Relative):
    GAINS: ClassVar = {
        "position_exponent": 0.25, "rate_exponent": 0.2, "position_time": 30.0, "rate_time": 5.0,
        "position_gain": 1.0, "rate_gain": 4.0, "switching_gain": 1e-4,
    }  # fmt: skip

    def design(self, sigma, w):
        h1, h2, t1, t2 = self.position_exponent, self.rate_exponent, self.position_time, self.rate_time
        matrix = kinematic_matrix(sigma)
        speed = matrix @ w
        gain, slope = predefined(
            0.5 * sigma @ sigma, h1, t1, (2 * h1 * t1 * self.position_gain) ** (-1 / h1)
        )  # fmt: skip
        s = speed + gain * sigma
        rate_gain = predefined(0.5 * s @ s, h2, t2, (2 * h2 * t2 * self.rate_gain) ** (-1 / h2))[0]
        wanted = -rate_gain * s
        wanted = wanted - self.switching_gain * np.tanh(s / (10.0 * self.switching_gain / self.rate_gain))
        change = gain * speed + slope * (sigma @ speed) * sigma
        turned = kinematic_matrix_rate(sigma, speed) @ w
        return s, wanted, np.linalg.solve(matrix, wanted - turned - change)
