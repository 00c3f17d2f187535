"""What the keys of a viewer do to a session."""

from __future__ import annotations

from ftac_gym.viewer.session import Session


def press(session: Session, key: str, shift: bool = False) -> str:
    """Do what a key asks for.

    Parameters
    ----------
    session
        What is watched.
    key
        Name of the key: a digit, ``"tab"``, ``"backspace"``, ``"space"``, ``"right"``, ``"up"``, ``"down"``, ``"r"`` or
        ``"n"``; others do nothing.
    shift
        Whether the shift key is held: a digit then mends, and the tabulator goes backwards.

    Returns
    -------
    What was done, in words; empty if nothing.
    """
    if key.isdigit():
        wheel = int(key)
        if shift:
            return f"wheel {wheel} mended" if session.repair(wheel) else f"there is no wheel {wheel}"
        name = session.kind.replace("_", " ")
        return name if session.strike(wheel) else f"{name} does not fit wheel {wheel}"
    match key:
        case "tab":
            session.choose(-1 if shift else 1)
            return ""
        case "backspace":
            session.repair_all()
            return "all mended"
        case "space":
            session.paused = not session.paused
            return ""
        case "right":
            session.paused = True
            session.step()
            return "one control period"
        case "up" | "down":
            session.hurry(2.0 if key == "up" else 0.5)
            return ""
        case "r":
            session.restart()
            return "the same episode again"
        case "n":
            session.restart(session.episode + 1)
            return "the next episode"
    return ""
