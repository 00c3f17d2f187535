"""Colours of the 3-D view; those with a meaning are distinct for the colour-blind."""

Color = tuple[int, int, int]

SPACE: Color = (14, 18, 32)
PANEL: Color = (24, 30, 48)
LINE: Color = (62, 72, 100)
GRATICULE: Color = (40, 48, 72)
TEXT: Color = (232, 236, 244)
FAINT: Color = (150, 160, 184)
BODY: Color = (196, 190, 176)
CELLS: Color = (52, 88, 168)
TARGET: Color = (120, 200, 255)
TRAIL: Color = (240, 228, 66)
AXES: tuple[Color, Color, Color] = ((213, 94, 0), (0, 158, 115), (86, 180, 233))
HEALTHY: Color = (0, 190, 140)
DEGRADED: Color = (230, 159, 0)
DEAD: Color = (235, 84, 60)
GOOD: Color = (0, 190, 140)


def dimmed(color: Color, share: float = 0.5) -> Color:
    """Return a colour at a share of its brightness, in [0, 1]."""
    red, green, blue = (int(share * part) for part in color)
    return (red, green, blue)


def health(effectiveness: float, faulty: bool) -> tuple[Color, str]:
    """Return colour and label of the state of a wheel.

    Parameters
    ----------
    effectiveness
        Share of the command that it gives, in [0, 1].
    faulty
        Whether any of its faults acts.
    """
    if not faulty:
        return HEALTHY, "ok"
    return (DEAD, "lost") if effectiveness < 0.05 else (DEGRADED, "faulty")
