"""The observer and the laws of Li, Xu and Chang 2023 for one spacecraft, written out from the paper rule by rule.

Nothing of the package's model, observers or laws is used; gains, which are data, are handed in.
"""

from itertools import product

import numpy as np
from helpers.laws import IDENTITY, relative, rotation, sig, skew

SECTOR = 0.7
CORNERS = [np.array(corner) for corner in product((SECTOR, -SECTOR), repeat=3)]


def firing(rate):
    """h_1, ..., h_8: products of (0.7 +- w_j) / 1.4."""
    inside = [min(max(value, -SECTOR), SECTOR) for value in rate]
    shares = []
    for corner in CORNERS:
        share = 1.0
        for value, edge in zip(inside, corner, strict=True):
            share *= (SECTOR + np.sign(edge) * value) / (2.0 * SECTOR)
        shares.append(share)
    return shares


class FlexibleModel:
    """Eqs. (2), (6)-(9) of a nominal flexible spacecraft."""

    def __init__(self, spacecraft):
        modes = spacecraft.appendages
        self.inertia, self.delta = np.array(spacecraft.inertia), np.array(modes.coupling)
        self.axes, self.limits = np.array(spacecraft.wheels.axes), spacecraft.wheels.torque_limits
        self.count = len(self.delta)
        frequency = np.array(modes.frequencies)
        self.stiffness = np.diag(frequency**2)
        self.damping = np.diag(2.0 * np.array(modes.damping_ratios) * frequency)
        self.quick = self.inertia - self.delta.T @ self.delta
        self.input = np.linalg.inv(self.quick)

    def state(self, rate):
        """A at a rate."""
        return -self.input @ skew(rate) @ self.inertia

    def vibration_torque(self, rate, eta, swing):
        """Torque of the appendages on the body [N m], with w in the place of a corner."""
        delta = self.delta
        return delta.T @ (self.stiffness @ eta + self.damping @ swing) - skew(rate) @ delta.T @ swing

    def accelerations(self, rate, torque, eta, swing):
        """w' and eta'' from the mass matrix [[J, delta'], [delta, I]]."""
        mass = np.block([[self.inertia, self.delta.T], [self.delta, np.eye(self.count)]])
        turning = np.cross(rate, self.inertia @ rate + self.delta.T @ swing)
        forces = np.concatenate([torque - turning, -self.damping @ swing - self.stiffness @ eta])
        solved = np.linalg.solve(mass, forces)
        return solved[:3], solved[3:]


class ReferenceObserver:
    """Eqs. (16), (17) with sums over the rules, either with y' or with the integral of Eq. (22)."""

    def __init__(self, spacecraft, gains, torque_bound=None, vibration_bound=None):
        self.model, self.gains = FlexibleModel(spacecraft), gains
        self.torque_bound, self.vibration_bound = torque_bound, vibration_bound

    def outputs(self, state, rate):
        """The wanted and the allowed f^, varpi^ and eta^, eta^'."""
        gains, mismatch, count = self.gains, rate - state[:3], self.model.count
        wanted = state[3:6] + gains.fault_proportional @ mismatch
        fault = wanted if self.torque_bound is None else np.clip(wanted, -self.torque_bound, self.torque_bound)
        whole = state[6:] + gains.vibration_proportional @ mismatch
        vibration = np.append(whole[:count], whole[count:] - self.model.delta @ rate)
        if self.vibration_bound is not None and np.abs(vibration).sum() > self.vibration_bound:
            vibration = vibration * self.vibration_bound / np.abs(vibration).sum()
        return wanted, fault, whole, vibration

    def proportional_integral(self, state, rate, torque):
        """The slope of x^ and of the two integrals."""
        wanted, fault, whole, vibration = self.outputs(state, rate)
        change, f_change, v_change = self._sums(state[:3], fault, whole, vibration, rate, torque)
        if self.torque_bound is not None:
            for axis in range(3):
                if abs(wanted[axis]) >= self.torque_bound and wanted[axis] * f_change[axis] > 0.0:
                    f_change[axis] = 0.0
        return np.concatenate([change, f_change, v_change])

    def derivative(self, state, rate, acceleration, torque):
        """The slope of x^, f^ and varpi^ as printed, without bounds; the rate has to have a derivative."""
        gains, count = self.gains, self.model.count
        vibration = np.append(state[6 : 6 + count], state[6 + count :] - self.model.delta @ rate)
        change, f_change, v_change = self._sums(state[:3], state[3:6], state[6:], vibration, rate, torque)
        drift = acceleration - change
        f_change, v_change = (
            f_change + gains.fault_proportional @ drift,
            v_change + gains.vibration_proportional @ drift,
        )
        return np.concatenate([change, f_change, v_change])

    def _sums(self, estimated, fault, whole, vibration, rate, torque):
        model, gains = self.model, self.gains
        mismatch, count = rate - estimated, model.count
        change, f_change, v_change = np.zeros(3), np.zeros(3), np.zeros(2 * count)
        eta, swing = vibration[:count], vibration[count:]
        whole_eta, whole_swing = whole[:count], whole[count:]
        own = np.append(
            whole_swing - model.delta @ rate,
            -model.stiffness @ whole_eta - model.damping @ whole_swing + model.damping @ model.delta @ rate,
        )
        for rule, (share, corner) in enumerate(zip(firing(rate), CORNERS, strict=True)):
            push = torque + fault + model.vibration_torque(corner, eta, swing)
            change += share * (model.state(corner) @ estimated + model.input @ push + gains.rate[rule] @ mismatch)
            f_change += share * gains.fault[rule] @ mismatch
            v_change += share * (own + gains.vibration[rule] @ mismatch)
        return change, f_change, v_change

    def begin(self, rate, know_rate=True):
        """f^ = 0, and either w^ = w and a still appendage, or w^ = 0 and varpi^ = 0."""
        count = self.model.count
        if know_rate:
            return np.concatenate([rate, np.zeros(3 + count), self.model.delta @ rate])
        gains = self.gains
        return np.concatenate([np.zeros(3), -gains.fault_proportional @ rate, -gains.vibration_proportional @ rate])

    def history(self, rates, commands, period, substeps=1, know_rate=True, interpolate=True, euler=False):
        """f^ and the torque of vibration (T, 6) at samples (T, 3), for commands (T, m) of the periods before them."""
        state, results, before = None, [], None
        for rate, command in zip(rates, commands, strict=True):
            if state is None:
                state = self.begin(rate, know_rate)
            else:
                state = self._sampled(state, before, rate, command, period, substeps, interpolate, euler)
            _, fault, _, vibration = self.outputs(state, rate)
            count = self.model.count
            results.append(np.append(fault, self.model.vibration_torque(rate, vibration[:count], vibration[count:])))
            before = rate
        return np.array(results)

    def _sampled(self, state, before, after, command, period, substeps, interpolate, euler):
        torque, h = self.model.axes @ command, period / substeps

        def slope(time, x):
            rate = before + time / period * (after - before) if interpolate else before
            return self.proportional_integral(x, rate, torque)

        for number in range(substeps):
            time = number * h
            k1 = slope(time, state)
            if euler:
                state = state + h * k1
                continue
            k2 = slope(time + h / 2, state + h / 2 * k1)
            k3 = slope(time + h / 2, state + h / 2 * k2)
            k4 = slope(time + h, state + h * k3)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        return state


# ------------------------------------------------------------------------------------------------------------- laws


class Law:
    """Errors (3)-(5), s (39) and g(s) (36), for an attitude, a rate and a reference (q_d, w_d, w_d')."""

    def __init__(self, spacecraft, beta=2.0, short_way=False, feedback=None):
        self.model, self.beta, self.short_way = FlexibleModel(spacecraft), beta, short_way
        self.feedback = feedback

    def errors(self, q, w, reference):
        error = relative(q, reference[0])
        if self.short_way and error[0] < 0.0:
            error = -error
        matrix = rotation(error)
        return error[0], error[1:], w - matrix @ reference[1], matrix

    def variable(self, q, w, reference):
        _, vector, rate_error, _ = self.errors(q, w, reference)
        return rate_error + self.beta * vector

    def rest(self, q, w, reference):
        """g(s) [rad/s^2], Eq. (36)."""
        model = self.model
        scalar, vector, rate_error, matrix = self.errors(q, w, reference)
        turning = model.input @ skew(w) @ model.inertia
        return (
            0.5 * self.beta * (scalar * IDENTITY + skew(vector)) @ rate_error
            + turning @ (self.beta * vector)
            - (turning - skew(rate_error)) @ matrix @ reference[1]
            - matrix @ reference[2]
        )

    def compensated(self, q, w, reference):
        return np.linalg.solve(self.model.input, self.rest(q, w, reference))

    def fuzzy_smc(self, q, w, reference, sigma1=0.2, sigma2=0.15, layer=1e-4):
        """(40), (64) without the estimates."""
        s = self.variable(q, w, reference)
        virtual = sum(share * gain @ s for share, gain in zip(firing(w), self.feedback, strict=True))
        robust = sigma1 * s + sigma2 * s / (np.linalg.norm(s) + layer)
        return virtual - robust - self.compensated(q, w, reference)

    def fuzzy_pd(self, q, w, reference, kp=20.0, kd=60.0, whole=True):
        """(69) without the estimates; else w x J w and the acceleration of the reference alone are compensated."""
        _, vector, rate_error, matrix = self.errors(q, w, reference)
        torque = -kp * vector - kd * rate_error
        if whole:
            return torque - self.compensated(q, w, reference)
        ahead = matrix @ reference[2] - np.cross(rate_error, matrix @ reference[1])
        return torque + np.cross(w, self.model.inertia @ w) + self.model.quick @ ahead


class Integral(Law):
    """(70), (71), with the trapezoidal rule."""

    def __init__(self, *arguments, period, sigma=0.002, layer=0.01, **others):
        super().__init__(*arguments, **others)
        self.period, self.sigma, self.layer, self.slopes = period, sigma, layer, []

    def torque(self, q, w, reference):
        s = self.variable(q, w, reference)
        shares = firing(w)
        closed = [self.model.state(c) + self.model.input @ k for c, k in zip(CORNERS, self.feedback, strict=True)]
        self.slopes.append(sum(share * matrix @ s for share, matrix in zip(shares, closed, strict=True)))
        whole = s - np.trapezoid(self.slopes, dx=self.period, axis=0)
        gain = sum(h * np.linalg.norm(k @ s) for h, k in zip(shares, self.feedback, strict=True))
        gain += self.sigma + np.linalg.norm(whole)
        return -gain * s / (np.linalg.norm(s) + self.layer) - self.compensated(q, w, reference)


class FixedTime(Law):
    """The surface of section 5.3 with a class of reaching law and adaptive bounds."""

    def __init__(self, *arguments, period, forgetting=0.1, **others):
        super().__init__(*arguments, **others)
        self.period, self.forgetting, self.bounds = period, forgetting, np.zeros(2)

    @staticmethod
    def surface(x, k1=0.2, k2=0.2, r1=1.2, r2=0.6, phi=0.01):
        l1, l2 = (2.0 - r2) * phi ** (r2 - 1.0), (r2 - 1.0) * phi ** (r2 - 2.0)
        inner = l1 * x + l2 * x**2 * np.sign(x)
        return k1 * sig(x, r1) + k2 * np.where(np.abs(x) >= phi, sig(x, r2), inner)

    def variable(self, q, w, reference):
        _, vector, rate_error, _ = self.errors(q, w, reference)
        return rate_error + self.surface(vector)

    def torque(self, q, w, reference):
        model = self.model
        scalar, vector, rate_error, matrix = self.errors(q, w, reference)
        s, size = self.variable(q, w, reference), np.linalg.norm(self.variable(q, w, reference))
        turning = 0.5 * (scalar * IDENTITY + skew(vector)) @ rate_error
        step = 1e-6
        moving = (self.surface(vector + step * turning) - self.surface(vector - step * turning)) / (2.0 * step)
        ahead = matrix @ reference[2] - np.cross(rate_error, matrix @ reference[1])
        speed = np.array([1.0, np.linalg.norm(w)])
        torque = np.cross(w, model.inertia @ w) + model.quick @ (ahead - moving)
        torque -= 20.0 * sig(s, 1.5) + 8.0 * sig(s, 0.6) + self.bounds @ speed * s / (size + 0.01)
        self.bounds = self.bounds + self.period * (speed * size - self.forgetting * self.bounds)
        return torque
