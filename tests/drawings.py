"""What the tests look for in pictures drawn in SVG."""

from __future__ import annotations

import re
from xml.etree import ElementTree

SVG = "{http://www.w3.org/2000/svg}"
LETTER = 0.54  # of the height of a letter, its width on the average
HEIGHTS = {"tick": 12.0, "small": 12.0}  # [px] of letters by class; others as below
HEIGHT = 13.0


def cut_off(svg: str) -> list[str]:
    """Texts of a picture that run out of it, by an estimate of their widths."""
    root = ElementTree.fromstring(svg)
    _, _, width, height = map(float, root.attrib["viewBox"].split())
    found = []
    for text in root.iter(f"{SVG}text"):
        turned = re.match(r"translate\((\S+) (\S+)\) rotate\(-90\)", text.get("transform", ""))
        x, y = (float(v) for v in (turned.groups() if turned else (text.attrib["x"], text.attrib["y"])))
        low, high = span(text, -y if turned else x)
        most = (-height, 0.0) if turned else (0.0, width)
        across = x if turned else y
        if not (most[0] <= low and high <= most[1] and 0.0 <= across <= (width if turned else height)):
            found.append(str(text.text))
    return found


def span(text: ElementTree.Element, at: float) -> tuple[float, float]:
    """From where to where a text goes along its line [px]."""
    styles = text.get("class", "").split()
    long = LETTER * next((HEIGHTS[s] for s in styles if s in HEIGHTS), HEIGHT) * len(text.text or "")
    start = at - (0.5 * long if "middle" in styles else long if "end" in styles else 0.0)
    return start, start + long
