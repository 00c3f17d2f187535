"""Numbers, words and bars around the scene."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ftac_gym.attitude import quaternion_error, rotate_to_body
from ftac_gym.envs.rendering import mesh, palette
from ftac_gym.envs.rendering.palette import Color
from ftac_gym.envs.rendering.snapshot import Snapshot
from ftac_gym.envs.rendering.toolkit import Lettering
from ftac_gym.task.scenario import Scenario

NEAREST, FARTHEST = 1e-3, 180.0
"""Pointing errors [deg] at the middle and at the edge of the inset, which is logarithmic in between."""


class Readouts:
    """Draws what cannot be seen from the craft itself.

    Parameters
    ----------
    pygame
        The drawing library.
    scenario
        Its wheels' limits and its limits of success.
    width, height
        Of the frame [pixels].
    """

    def __init__(self, pygame: Any, scenario: Scenario, width: int, height: int) -> None:
        self._pygame = pygame
        self._size = (width, height)
        self._scale = min(width / 640.0, height / 480.0)
        wheels = scenario.spacecraft.wheels
        self._torque_limits, self._momentum_limits = wheels.torque_limits, wheels.momentum_limits
        # What has no limit is drawn to the largest that has been seen.
        self._seen = np.full((2, wheels.count), 1e-6)
        self._success = scenario.success
        self._bends = scenario.spacecraft.appendages is not None
        self.bar_height = int(98 * self._scale)
        """Height of the strip with the wheels [pixels]."""
        self._letters = Lettering(pygame)

    def _text(self, text: str, size: int, color: Color) -> Any:
        return self._letters.text(text, max(12, int(size * self._scale)), color)

    def write(self, surface: Any, text: str, place: tuple[float, float], size: int, color: Color) -> int:
        """Write a line with its top left corner at a place; return its height."""
        drawn = self._text(text, size, color)
        surface.blit(drawn, place)
        return int(drawn.get_height())

    def draw(self, surface: Any, snapshot: Snapshot) -> None:
        """Draw everything."""
        margin = 10 * self._scale
        top = margin
        for text, size, color in self._lines(snapshot):
            top += self.write(surface, text, (margin, top), size, color) + 2 * self._scale
        self._faults(surface, snapshot)
        self._inset(surface, snapshot)
        self._bars(surface, snapshot)

    def _lines(self, snapshot: Snapshot) -> list[tuple[str, int, Color]]:
        state, color = ("slewing", palette.FAINT)
        if snapshot.on_target:
            state, color = ("on target", palette.GOOD)
        if snapshot.success:
            state = f"on target for {self._success.hold:g} s: success"
        lines = [(snapshot.policy, 30, palette.TEXT)] if snapshot.policy else []
        lines += [
            (f"{snapshot.time:.1f} s", 26, palette.TEXT),
            (f"error {_short(math.degrees(snapshot.attitude_error))} deg", 23, palette.TEXT),
            (f"rate error {_short(math.degrees(snapshot.rate_error))} deg/s", 23, palette.TEXT),
            (state, 23, color),
        ]
        if self._bends:
            lines.append((f"bending x{mesh.EXAGGERATION:g}", 19, palette.FAINT))
        return lines

    def _faults(self, surface: Any, snapshot: Snapshot) -> None:
        width, _ = self._size
        right, top = width - 10 * self._scale, 10 * self._scale
        words = snapshot.faults or ("no fault",)
        color = palette.DEAD if snapshot.faults else palette.FAINT
        for size in (23, 20, 17):
            lines = [line for item in words for line in self._wrapped(item, size, 0.48 * width)]
            height = self._text("X", size, color).get_height() + 2 * self._scale
            if len(lines) * height < 0.4 * self._size[1]:
                break
        for line in lines:
            drawn = self._text(line, size, color)
            surface.blit(drawn, (right - drawn.get_width(), top))
            top += height

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
        """Draw where the target's boresight is, seen along the own one; distances are logarithmic."""
        pygame, radius = self._pygame, int(46 * self._scale)
        center = (
            self._size[0] - radius - 14 * self._scale,
            self._size[1] - self.bar_height - radius - 24 * self._scale,
        )
        pygame.draw.circle(surface, palette.PANEL, center, radius)
        pygame.draw.aacircle(surface, palette.LINE, center, radius, 1)
        cone = math.degrees(self._success.angle)
        pygame.draw.aacircle(surface, palette.GOOD, center, max(3.0, radius * logarithmic(cone)), 1)
        for edge in ((radius, 0), (0, radius)):
            start, end = (center[0] - edge[0], center[1] - edge[1]), (center[0] + edge[0], center[1] + edge[1])
            pygame.draw.line(surface, palette.LINE, start, end)
        error = quaternion_error(snapshot.attitude, snapshot.reference_attitude)
        target = rotate_to_body(error, np.array([0.0, 0.0, 1.0]))
        angle = math.degrees(math.atan2(math.hypot(target[0], target[1]), target[2]))
        direction = math.atan2(target[1], target[0])
        reach = radius * logarithmic(angle)
        place = (center[0] + reach * math.cos(direction), center[1] - reach * math.sin(direction))
        pygame.draw.circle(surface, palette.GHOST, place, max(3.0, 4 * self._scale))
        label = self._text(f"boresight error, ring {cone:.2g} deg", 15, palette.FAINT)
        surface.blit(label, (self._size[0] - label.get_width() - 8 * self._scale, center[1] + radius + 4 * self._scale))

    def _bars(self, surface: Any, snapshot: Snapshot) -> None:
        width, height = self._size
        top, count = height - self.bar_height, len(snapshot.wheel_torque)
        self._pygame.draw.rect(surface, palette.PANEL, (0, top, width, self.bar_height))
        self._seen = np.maximum(self._seen, np.abs([snapshot.wheel_torque, snapshot.wheel_momentum]))
        column = width / count
        for wheel in range(count):
            left, inner = wheel * column + 8 * self._scale, column - 16 * self._scale
            color, word = palette.health(float(snapshot.effectiveness[wheel]), bool(snapshot.faulty[wheel]))
            title = f"wheel {wheel}: {word}" if count <= 5 else f"{wheel}: {word}"
            line = top + 6 * self._scale
            line += self.write(surface, title, (left, line), 20, color) + 3 * self._scale
            for row, (value, limits, unit) in enumerate(
                (
                    (snapshot.wheel_torque[wheel], self._torque_limits, "N m"),
                    (snapshot.wheel_momentum[wheel], self._momentum_limits, "N m s"),
                )
            ):
                limited = bool(np.isfinite(limits[wheel]))
                limit = float(limits[wheel] if limited else self._seen[row, wheel])
                box = (left, line, inner, 13 * self._scale)
                command = float(snapshot.command[wheel]) if row == 0 else None
                self._bar(surface, box, float(value) / limit, None if command is None else command / limit, color)
                line += 14 * self._scale
                text = f"{value:+.3g} of {limit:.3g} {unit}" if limited else f"{value:+.3g} {unit}, no limit"
                line += self.write(surface, text, (left, line), 15, palette.FAINT) + 4 * self._scale

    def _bar(self, surface: Any, box: tuple[float, ...], value: float, command: float | None, color: Color) -> None:
        pygame = self._pygame
        left, top, width, height = box
        middle = left + width / 2.0
        pygame.draw.rect(surface, palette.SPACE, box)
        share = min(max(value, -1.0), 1.0)
        filled = (min(middle, middle + share * width / 2.0), top, abs(share) * width / 2.0, height)
        pygame.draw.rect(surface, color, filled)
        pygame.draw.rect(surface, palette.LINE, box, 1)
        pygame.draw.line(surface, palette.FAINT, (middle, top), (middle, top + height - 1))
        if command is not None:
            asked = middle + min(max(command, -1.0), 1.0) * (width / 2.0 - 1.0)
            pygame.draw.line(
                surface, palette.TEXT, (asked, top - 1), (asked, top + height), max(2, int(2 * self._scale))
            )


def logarithmic(angle: float) -> float:
    """Return where an angle [deg] lies between the middle (0) and the edge (1) of the inset."""
    share = math.log(max(angle, NEAREST) / NEAREST) / math.log(FARTHEST / NEAREST)
    return min(share, 1.0)


def _short(value: float) -> str:
    return f"{value:.1f}" if value >= 1.0 else f"{value:.4f}"
