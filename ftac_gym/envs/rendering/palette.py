"""Colours of the 3-D view, of which the colour-blind can tell those that mean something apart."""

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
    """Return the colour and the word for the state of a wheel.

    Parameters
    ----------
    effectiveness
        Share of its command that it gives, in [0, 1].
    faulty
        Whether anything is wrong with it.
    """
    if not faulty:
        return HEALTHY, "ok"
    return (DEAD, "lost") if effectiveness < 0.05 else (DEGRADED, "faulty")
