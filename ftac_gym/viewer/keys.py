"""Keys of the viewer."""

from __future__ import annotations

from ftac_gym.viewer.session import Session


def press(session: Session, key: str, shift: bool = False) -> str:
    """Apply a key to a session.

    Parameters
    ----------
    session
        The session.
    key
        Name of the key: a digit, ``"tab"``, ``"backspace"``, ``"space"``, ``"right"``, ``"up"``, ``"down"``, ``"r"`` or
        ``"n"``; others do nothing.
    shift
        Whether the shift key is held: a digit then clears faults, and the tabulator goes backwards.

    Returns
    -------
    A notice to show; empty if there is none.
    """
    if key.isdigit():
        wheel = int(key)
        if shift:
            return f"wheel {wheel}: faults cleared" if session.clear_faults(wheel) else f"there is no wheel {wheel}"
        name = session.kind.replace("_", " ")
        return name if session.add_fault(wheel) else f"{name} does not fit wheel {wheel}"
    match key:
        case "tab":
            session.choose_kind(-1 if shift else 1)
        case "backspace":
            session.clear_all_faults()
            return "all faults cleared"
        case "space":
            session.paused = not session.paused
        case "right":
            session.paused = True
            session.step()
            return "one control period"
        case "up" | "down":
            session.change_speed(2.0 if key == "up" else 0.5)
        case "r":
            session.restart()
            return "the same episode again"
        case "n":
            session.restart(session.episode + 1)
            return "the next episode"
    return ""
