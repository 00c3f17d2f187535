"""Numbers, text and bars around the scene."""

import math
from typing import Any

import numpy as np

from ftac_gym.attitude import quaternion_error, rotate_to_body
from ftac_gym.envs.rendering import mesh, palette
from ftac_gym.envs.rendering.palette import Color
from ftac_gym.envs.rendering.snapshot import Snapshot
from ftac_gym.envs.rendering.toolkit import Lettering, pygame
from ftac_gym.task.scenario import Scenario

NEAREST, FARTHEST = 1e-3, 180.0
"""Pointing errors [deg] at the middle and at the edge of the inset, which is logarithmic in between."""


class Readouts:
    """Drawing of all that a picture of the spacecraft itself does not show.

    Parameters
    ----------
    scenario
        Limits of the wheels and of success.
    width, height
        Size of the frame [pixels].

    Attributes
    ----------
    bar_height
        Height of the strip with the wheels [pixels].
    """

    def __init__(self, scenario: Scenario, width: int, height: int) -> None:
        self._size = (width, height)
        self._scale = min(width / 640.0, height / 480.0)
        wheels = scenario.spacecraft.wheels
        self._limits = np.array([wheels.torque_limits, wheels.momentum_limits])
        # Without a limit, a bar is relative to the largest value so far.
        self._largest = np.full((2, wheels.count), 1e-6)
        self._success = scenario.success
        self._bends = scenario.spacecraft.appendages is not None
        self.bar_height = int(98 * self._scale)
        self._letters = Lettering()

    def _text(self, text: str, size: int, color: Color) -> Any:
        return self._letters.text(text, max(12, int(size * self._scale)), color)

    def _write(self, surface: Any, text: str, place: tuple[float, float], size: int, color: Color) -> int:
        """Write a line with its top left corner at a place; return its height."""
        drawn = self._text(text, size, color)
        surface.blit(drawn, place)
        return int(drawn.get_height())

    def draw(self, surface: Any, snapshot: Snapshot) -> None:
        """Draw everything."""
        margin = 10 * self._scale
        top = margin
        for text, size, color in self._lines(snapshot):
            top += self._write(surface, text, (margin, top), size, color) + 2 * self._scale
        self._faults(surface, snapshot)
        self._inset(surface, snapshot)
        self._bars(surface, snapshot)

    def _lines(self, snapshot: Snapshot) -> list[tuple[str, int, Color]]:
        state, color = ("on target", palette.GOOD) if snapshot.on_target else ("slewing", palette.FAINT)
        if snapshot.success:
            state = f"on target for {self._success.share:.0%} of {self._success.hold:g} s: success"
        lines = [
            (snapshot.policy, 30, palette.TEXT),
            (f"{snapshot.time:.1f} s", 26, palette.TEXT),
            (f"error {_short(math.degrees(snapshot.attitude_error))} deg", 23, palette.TEXT),
            (f"rate error {_short(math.degrees(snapshot.rate_error))} deg/s", 23, palette.TEXT),
            (state, 23, color),
        ]
        if self._bends:
            lines.append((f"bending x{mesh.EXAGGERATION:g}", 19, palette.FAINT))
        return [line for line in lines if line[0]]

    def _faults(self, surface: Any, snapshot: Snapshot) -> None:
        width, height = self._size
        color = palette.DEAD if snapshot.faults else palette.FAINT
        for size in (23, 20, 17):
            lines = [
                line for item in snapshot.faults or ("no fault",) for line in self._wrapped(item, size, 0.48 * width)
            ]
            spacing = self._text("X", size, color).get_height() + 2 * self._scale
            if len(lines) * spacing < 0.4 * height:
                break
        for index, line in enumerate(lines):
            drawn = self._text(line, size, color)
            top = 10 * self._scale + index * spacing
            surface.blit(drawn, (width - 10 * self._scale - drawn.get_width(), top))

    def _wrapped(self, text: str, size: int, most: float) -> list[str]:
        lines = [""]
        for word in text.split():
            longer = f"{lines[-1]} {word}".strip()
            if lines[-1] and self._text(longer, size, palette.DEAD).get_width() > most:
                lines.append(word)
            else:
                lines[-1] = longer
        return lines

    def _inset(self, surface: Any, snapshot: Snapshot) -> None:
        """Draw the boresight of the target, seen along that of the spacecraft; distances are logarithmic."""
        radius, (width, height) = int(46 * self._scale), self._size
        x, y = width - radius - 14 * self._scale, height - self.bar_height - radius - 24 * self._scale
        pygame.draw.circle(surface, palette.PANEL, (x, y), radius)
        pygame.draw.aacircle(surface, palette.LINE, (x, y), radius, 1)
        cone = math.degrees(self._success.angle)
        pygame.draw.aacircle(surface, palette.GOOD, (x, y), max(3.0, radius * logarithmic(cone)), 1)
        pygame.draw.line(surface, palette.LINE, (x - radius, y), (x + radius, y))
        pygame.draw.line(surface, palette.LINE, (x, y - radius), (x, y + radius))
        error = quaternion_error(snapshot.attitude, snapshot.reference_attitude)
        target = rotate_to_body(error, np.array([0.0, 0.0, 1.0]))
        reach = radius * logarithmic(math.degrees(math.atan2(math.hypot(target[0], target[1]), target[2])))
        direction = math.atan2(target[1], target[0])
        place = (x + reach * math.cos(direction), y - reach * math.sin(direction))
        pygame.draw.circle(surface, palette.TARGET, place, max(3.0, 4 * self._scale))
        label = self._text(f"boresight error, ring {cone:.2g} deg", 15, palette.FAINT)
        surface.blit(label, (width - label.get_width() - 8 * self._scale, y + radius + 4 * self._scale))

    def _bars(self, surface: Any, snapshot: Snapshot) -> None:
        width, height = self._size
        top, count = height - self.bar_height, len(snapshot.wheel_torque)
        pygame.draw.rect(surface, palette.PANEL, (0, top, width, self.bar_height))
        values = np.array([snapshot.wheel_torque, snapshot.wheel_momentum])
        self._largest = np.maximum(self._largest, np.abs(values))
        limits = np.where(np.isfinite(self._limits), self._limits, self._largest)
        commands = (snapshot.command / limits[0], (None,) * count)
        for wheel in range(count):
            left, inner = (wheel * width / count) + 8 * self._scale, width / count - 16 * self._scale
            color, state = palette.health(float(snapshot.effectiveness[wheel]), bool(snapshot.faulty[wheel]))
            title = f"wheel {wheel}: {state}" if count <= 5 else f"{wheel}: {state}"
            line = top + 6 * self._scale
            line += self._write(surface, title, (left, line), 20, color) + 3 * self._scale
            for row, unit in enumerate(("N m", "N m s")):
                value, limit = values[row, wheel], limits[row, wheel]
                box = (left, line, inner, 13 * self._scale)
                self._bar(surface, box, value / limit, commands[row][wheel], color)
                line += 14 * self._scale
                limited = np.isfinite(self._limits[row, wheel])
                text = f"{value:+.3g} of {limit:.3g} {unit}" if limited else f"{value:+.3g} {unit}, no limit"
                line += self._write(surface, text, (left, line), 15, palette.FAINT) + 4 * self._scale

    def _bar(self, surface: Any, box: tuple[float, ...], value: float, command: float | None, color: Color) -> None:
        left, top, width, height = box
        middle, bottom = left + width / 2.0, top + height
        pygame.draw.rect(surface, palette.SPACE, box)
        share = min(max(value, -1.0), 1.0)
        filled = (min(middle, middle + share * width / 2.0), top, abs(share) * width / 2.0, height)
        pygame.draw.rect(surface, color, filled)
        pygame.draw.rect(surface, palette.LINE, box, 1)
        pygame.draw.line(surface, palette.FAINT, (middle, top), (middle, bottom - 1))
        if command is not None:
            x, thickness = middle + min(max(command, -1.0), 1.0) * (width / 2.0 - 1.0), max(2, int(2 * self._scale))
            pygame.draw.line(surface, palette.TEXT, (x, top - 1), (x, bottom), thickness)


def logarithmic(angle: float) -> float:
    """Return the distance of an angle [deg] from the middle (0) of the inset; its edge is at 1."""
    share = math.log(max(angle, NEAREST) / NEAREST) / math.log(FARTHEST / NEAREST)
    return min(share, 1.0)


def _short(value: float) -> str:
    return f"{value:.1f}" if value >= 1.0 else f"{value:.4f}"
