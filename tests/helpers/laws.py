"""The fault-tolerant laws of one spacecraft written out from the papers, with matrices, and how to fly them.

Nothing of the package's baselines is used here: a law and a plant that agree with these have been implemented twice.
"""

import numpy as np
from scipy.integrate import solve_ivp

IDENTITY = np.eye(3)


def skew(v):
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def kinematic_matrix(sigma):
    """G of sigma' = G w."""
    return 0.25 * ((1.0 - sigma @ sigma) * IDENTITY + 2.0 * skew(sigma) + 2.0 * np.outer(sigma, sigma))


def kinematic_matrix_rate(sigma, change):
    """dG/dt, by the product rule."""
    outer = np.outer(change, sigma) + np.outer(sigma, change)
    return 0.25 * (-2.0 * (sigma @ change) * IDENTITY + 2.0 * skew(change) + 2.0 * outer)


def mrp(q):
    """The short-branch MRP of a quaternion."""
    q = -q if q[0] < 0.0 else q
    return q[1:] / (1.0 + q[0])


def rotation(q):
    """C with v_body = C v_inertial."""
    return (q[0] ** 2 - q[1:] @ q[1:]) * IDENTITY + 2.0 * np.outer(q[1:], q[1:]) - 2.0 * q[0] * skew(q[1:])


def relative(q, reference):
    """conj(q_d) (x) q."""
    return np.append(
        reference @ q, reference[0] * q[1:] - q[0] * reference[1:] - np.cross(reference[1:], q[1:])
    )  # fmt: skip


def sig(x, power):
    return np.abs(x) ** power * np.sign(x)


def sign(x, layer):
    return np.sign(x) if layer == 0.0 else np.tanh(x / layer)


class Target:
    """A reference sigma_d = amplitude sin(frequency t + phase), or the identity at rest."""

    def __init__(self, amplitude=(0.0, 0.0, 0.0), frequency=(0.0, 0.0, 0.0), phase=(0.0, 0.0, 0.0)):
        self.amplitude, self.frequency, self.phase = map(np.array, (amplitude, frequency, phase))

    def mrp(self, time):
        """sigma_d and its first two derivatives."""
        angle, f = self.frequency * time + self.phase, self.frequency
        wave = self.amplitude * np.sin(angle)
        return wave, self.amplitude * f * np.cos(angle), -f * f * wave

    def body(self, time):
        """The quaternion, and the rate and acceleration in the reference's own axes."""
        sigma, first, second = self.mrp(time)
        square = sigma @ sigma
        inverse = np.linalg.inv(kinematic_matrix(sigma))
        rate = inverse @ first
        acceleration = inverse @ (second - kinematic_matrix_rate(sigma, first) @ rate)
        return np.append(1.0 - square, 2.0 * sigma) / (1.0 + square), rate, acceleration


class NominalModel:
    """Nominal inertia, wheel axes, torque limit, control period and reference: the inputs of a law."""

    def __init__(self, scenario, target=None):
        self.inertia = np.array(scenario.spacecraft.inertia)
        self.inverse = np.linalg.inv(self.inertia)
        self.axes = np.array(scenario.spacecraft.wheels.axes)
        self.limits = scenario.spacecraft.wheels.torque_limits
        self.period = scenario.control_period
        self.target = target or Target()
        self.norms = np.linalg.svd(self.inverse)[1][0] * np.linalg.svd(self.axes)[1][0]

    def gyroscopic(self, rate):
        return np.cross(rate, self.inertia @ rate)

    def spread(self, torque, effectiveness, power):
        """u = E^p D' (J^-1 D E^(p+1) D')^-1 J^-1 torque, as printed in Eqs. (36), (70) for p = 2."""
        weights = np.diag(effectiveness**power)
        matrix = self.inverse @ self.axes @ np.diag(effectiveness ** (power + 1)) @ self.axes.T
        return weights @ self.axes.T @ np.linalg.inv(matrix) @ (self.inverse @ torque)

    def minimax(self, torque):
        """The smallest largest wheel torque, for equal wheels, three or four: a search along the null space."""
        command = np.linalg.pinv(self.axes) @ torque
        if len(command) == 3:
            return command
        null = np.linalg.svd(self.axes)[2][3]
        steps = [
            (command[j] * s - command[i]) / (null[i] - s * null[j])
            for i in range(4) for j in range(i) for s in (1.0, -1.0) if abs(null[i] - s * null[j]) > 1e-9
        ]  # fmt: skip
        return min((command + step * null for step in steps), key=lambda u: np.abs(u).max())


# ------------------------------------------------------------------------------------------------------------ plant


class Plant:
    """The true spacecraft: J w' = -w x J w + D (e u + b) + d, integrated by DOP853 between two samples."""

    def __init__(self, model, effectiveness, bias, torque):
        self.model, self.effectiveness, self.bias, self.torque = model, effectiveness, bias, torque

    def derivative(self, time, state, command, probe):
        """q' and w'; ``probe`` is a time inside the period, which decides which faults act."""
        q, w = state[:4], state[4:7]
        wheels = self.effectiveness(time, probe) * command + self.bias(time, probe)
        torque = -self.model.gyroscopic(w) + self.model.axes @ wheels + self.torque(time)
        turn = 0.5 * np.append(-q[1:] @ w, q[0] * w + np.cross(q[1:], w))
        return np.append(turn, self.model.inverse @ torque)

    def history(self, law, state, steps):
        """States (steps + 1, 7) and commands (steps, m) under a law ``law(time, q, w, last command)``."""
        period, states, commands = self.model.period, [np.array(state)], []
        last = np.zeros(self.model.axes.shape[1])
        for step in range(steps):
            time = step * period
            last = law(time, states[-1][:4], states[-1][4:], last)
            probe = time + 0.5 * period
            span = (time, time + period)
            arguments = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13, "args": (last, probe)}
            states.append(solve_ivp(self.derivative, span, states[-1], **arguments).y[:, -1])
            commands.append(last)
        return np.array(states), np.array(commands)


# -------------------------------------------------------------------------------------------------------- observers


class Perfect:
    """The estimate of healthy wheels."""

    def __init__(self, model):
        self.effectiveness, self.bias = np.ones(model.axes.shape[1]), np.zeros(model.axes.shape[1])
        self.disturbance = np.zeros(3)

    def update(self, rate, command):
        pass


class SlidingMode(Perfect):
    """Eqs. (15)-(18) of Zhang and Zhou 2019: semi-implicit Euler, gyroscopic torque at the middle of the period."""

    def __init__(self, model, gain=5.0, g1=200.0, g2=100.0, barrier=0.05, largest=50.0, smallest=0.05, layer=0.01):
        super().__init__(model)
        self.model, self.gain, self.g1, self.g2 = model, gain, g1, g2
        self.barrier, self.largest, self.smallest, self.layer = barrier, largest, smallest, layer
        self.estimate = self.previous = None
        self.mismatch = np.zeros(3)

    def update(self, rate, command):
        model, h = self.model, self.model.period
        if self.estimate is None:
            self.estimate = rate  # the rate is known: inside the barrier from the start
        else:
            size = np.abs(self.mismatch).sum()
            gain = min(size / (self.barrier - size), self.largest) if size < self.barrier else self.largest
            torque = model.axes @ (self.effectiveness * command + self.bias) + gain * sign(self.mismatch, self.layer)
            middle = self.estimate + 0.5 * (rate - self.previous)
            change = model.inverse @ (torque - model.gyroscopic(middle)) + self.gain * self.mismatch
            self.estimate = self.estimate + h * change
        self.previous, self.mismatch = rate, rate - self.estimate
        drive = model.axes.T @ model.inverse.T @ self.mismatch
        learned = self.effectiveness + h * self.g1 * command * drive
        self.effectiveness = np.clip(learned, self.smallest, 1.0)
        self.bias = self.bias + h * self.g2 * drive


class Learning(Perfect):
    """Eqs. (7), (8) of Cao, Gong and Han 2022."""

    def __init__(self, model, gain, first, second, forgetting=1.0, switching=0.0, full=1.0, smallest=1e-4):
        super().__init__(model)
        self.model, self.gain, self.first, self.second = model, gain, first, second
        self.forgetting, self.switching, self.full, self.smallest = forgetting, switching, full, smallest
        self.estimate = self.previous = None
        self.mismatch = np.zeros(3)

    def update(self, rate, command):
        model, last = self.model, self.mismatch
        fresh = self.estimate is None
        if fresh:
            self.estimate = rate
        else:
            middle = self.estimate + 0.5 * (rate - self.previous)
            torque = model.axes @ (self.effectiveness * command) - model.gyroscopic(middle) + self.disturbance
            self.estimate = self.estimate + model.period * model.inverse @ torque
        self.previous, self.mismatch = rate, rate - self.estimate
        self.disturbance = self.gain @ self.mismatch + self.switching * np.sign(self.mismatch)
        if fresh:
            return
        share = 1.0 if self.full is None else np.clip(command / self.full, -1.0, 1.0)
        learned = self.forgetting * self.effectiveness + share * (self.first @ self.mismatch + self.second @ last)
        self.effectiveness = np.clip(learned, self.smallest, 1.0)
