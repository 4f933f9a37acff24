"""Drawings within a page: SVG files made small, in the page's own colours, with styles that all of them share."""

from __future__ import annotations

import re
from collections.abc import Iterator
from xml.etree import ElementTree

from markupsafe import Markup

from lodbench.harness.report.charts.chart_data import (
    FAINT,
    INK,
    ON_COLOUR,
    PAGE,
    WARNING,
)

NAMED = {INK: "ink", FAINT: "faint", PAGE: "page", WARNING: "warn"}  # custom properties of the page
DARK_PAGE = "#0f1419"
LEAST_CONTRAST = 4.0  # of a drawing's colour on the dark page
_XLINK = "{http://www.w3.org/1999/xlink}href"
_NUMBER = re.compile(r"-?\d+\.\d+(?:e-?\d+)?")
_STEP = re.compile(r"(([ML])([^ A-Za-z]+) ([^ A-Za-z]+)|[A-Za-z][^A-Za-z]*)")
_COLOUR = re.compile(r"#[0-9a-f]{6}\b")
_FONT = re.compile(r"\s*(font-family|stroke-linejoin):[^;]*;?")  # the page's, and its default


class Drawings:
    """The drawings of one page, and the styles that they share.

    Ids are short and unique in the page. Each style is a class of the page, whatever drawing it is from; colours follow
    the page from light to dark.
    """

    def __init__(self) -> None:
        self._classes: dict[str, str] = {}
        self._ids = 0
        self._frames: dict[str, tuple[float, ...]] = {}

    def inline(self, svg: str, label: str) -> Markup:
        """An SVG file's drawing for use within the page.

        Args:
            svg: the file's text, as matplotlib writes it.
            label: what it shows, for those who cannot see it.

        Raises:
            ValueError: it is not XML.
        """
        try:
            root = ElementTree.fromstring(svg)
        except ElementTree.ParseError as error:
            raise ValueError(f"svg: expected a drawing, got {error}") from None
        used = set(re.findall(r'(?:url\(|href=")#([^")]+)', svg))
        names = {}
        for name in sorted(used):
            self._ids += 1
            names[name] = f"d{self._ids}"
        box = root.get("viewBox") or f"0 0 {root.get('width')} {root.get('height')}"
        self._frames = dict(_frames(root))
        inside = _merged("".join(self._written(child, names, {}) for child in root))
        title = Markup.escape(label)
        return Markup(  # our own drawing
            f'<svg viewBox="{_short(box)}" style="--w:{float(box.split()[2]):.0f}pt" role="img" '
            f'aria-label="{title}">{inside}</svg>'
        )

    def css(self) -> Markup:
        """The rules of every drawing's styles."""
        rules = [f".{name}{{{_themed(style)}}}" for style, name in self._classes.items()]
        colours = sorted({found for style in self._classes for found in _COLOUR.findall(style)})
        pairs = [(one, dark(one)) for one in colours if one not in NAMED and dark(one) != one]
        both = "".join(f"--{one[1:]}:light-dark({one},{other});" for one, other in pairs)
        rules.append(f"@supports (color: light-dark(#000, #fff)) {{:root{{{both}}}}}")
        return Markup("\n".join(rules))

    def _class(self, style: str) -> str:
        style = "; ".join(part.strip() for part in _FONT.sub("", style).split(";") if part.strip())
        return self._classes.setdefault(style, f"s{len(self._classes)}") if style else ""

    def _written(
        self, element: ElementTree.Element, names: dict[str, str], given: dict[str, str]
    ) -> str:
        """The element and all in it; `given` is what a group says for its members."""
        tag = element.tag.rpartition("}")[2]
        if tag in ("metadata", "style", "script", "title"):
            return ""
        own = dict(self._attributes(element, names))
        # a text's style is that of all in it; clip paths and patterns have ids that others name
        children = list(element)
        if tag == "g":
            shared = dict(given)
            for child in children[:1]:
                first = dict(self._attributes(child, names))
                alike = all(dict(self._attributes(c, names)).get("class") == first.get("class")
                            and c.tag == child.tag for c in children)  # fmt: skip
                if len(children) > 1 and alike and first.get("class") and "class" not in own:
                    own["class"] = shared["class"] = first["class"]
            text = "".join(self._written(child, names, shared) for child in children)
            if not text:
                return ""
            own = {k: v for k, v in own.items() if given.get(k) != v}
            return f"<g{_joined(own)}>{text}</g>" if own else text
        own = {k: v for k, v in own.items() if k != "class" or given.get(k) != v}
        text = str(Markup.escape((element.text or "").strip()))
        text += "".join(self._written(child, names, {}) for child in children)
        if tag == "defs" and not text:
            return ""
        return f"<{tag}{_joined(own)}>{text}</{tag}>" if text else f"<{tag}{_joined(own)}/>"

    def _attributes(
        self, element: ElementTree.Element, names: dict[str, str]
    ) -> Iterator[tuple[str, str]]:
        for key, value in element.attrib.items():
            if key == "id":
                if value in names:
                    yield "id", names[value]
            elif key == _XLINK:
                yield "href", f"#{names[value[1:]]}"
            elif key == "style":
                value = re.sub(r"url\(#([^)]+)\)", lambda found: f"url(#{names[found[1]]})", value)
                if found := self._class(value):
                    yield "class", found
            elif key == "clip-path" and _within(element, self._frames.get(value[5:-1])):
                continue  # it cuts nothing off
            elif key in ("clip-path", "fill", "stroke"):
                yield key, re.sub(r"url\(#([^)]+)\)", lambda f: f"url(#{names[f[1]]})", value)
            elif key == "transform":
                value = re.sub(r"rotate\(-?0(?: [^)]*)?\)", "", value).strip()
                if value:
                    yield key, _short(value)
            elif key in ("d", "x", "y", "width", "height", "points", "cx", "cy", "r"):
                yield key, _lines(_short(value)) if key == "d" else _short(value)
            elif key.startswith("{") or key in ("version",):
                continue
            else:
                yield key, value


def _joined(attributes: dict[str, str]) -> str:
    """Attributes as text, the class first."""
    ordered = sorted(attributes.items(), key=lambda item: item[0] != "class")
    return "".join(f' {key}="{Markup.escape(value)}"' for key, value in ordered)


def _frames(root: ElementTree.Element) -> Iterator[tuple[str, tuple[float, ...]]]:
    """The id of each clip path that is a rectangle, with left, top, right and bottom."""
    for path in root.iter():
        if path.tag.endswith("clipPath") and len(path) == 1 and path[0].tag.endswith("rect"):
            x, y, width, height = (float(path[0].get(k, 0)) for k in ("x", "y", "width", "height"))
            yield path.get("id", ""), (x - 1, y - 1, x + width + 1, y + height + 1)


def _within(element: ElementTree.Element, frame: tuple[float, ...] | None) -> bool:
    """Is a path, as matplotlib writes those, inside of the frame?"""
    numbers = [float(text) for text in re.findall(r"-?[\d.]+(?:e-?\d+)?", element.get("d", ""))]
    if frame is None or not numbers or element.get("transform"):
        return False
    left, top, right, bottom = frame
    across, down = numbers[::2], numbers[1::2]
    return min(across) >= left and max(across) <= right and min(down) >= top and max(down) <= bottom


def _merged(text: str) -> str:
    """Paths of one style that follow each other as one path."""
    pattern = re.compile(r'<path (class="\w+" )?d="([^"]*)"/>(?:<path (?(1)\1)d="([^"]*)"/>)+')

    def one(found: re.Match[str]) -> str:
        parts = re.findall(r'd="([^"]*)"', found[0])
        return f'<path {found[1] or ""}d="{"".join(parts)}"/>'

    return pattern.sub(one, text)


def _lines(path: str) -> str:
    """A path of lines from each point to the next, in hundredths so that nothing adds up; one of curves is left."""
    found: list[str] = []
    here = start = (0, 0)
    for whole, letter, x, y in _STEP.findall(path):
        if whole in "zZ":
            found.append("z")
            here = start
            continue
        if not letter:
            return path
        to = round(100 * float(x)), round(100 * float(y))
        across, down = (to[0] - here[0]) / 100, (to[1] - here[1]) / 100
        if letter == "M":
            start = to
            found.append(f"m{_pair(across, down)}" if found else f"M{_pair(*map(float, (x, y)))}")
        elif not across or not down:
            found.append(f"v{_least(down)}" if not across else f"h{_least(across)}")
        else:
            found.append(f"l{_pair(across, down)}")
        here = to
    return "".join(found) or path


def _least(value: float) -> str:
    """A number in as few letters as it needs."""
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return re.sub(r"^(-?)0\.", r"\1.", text)


def _pair(x: float, y: float) -> str:
    one, other = _least(x), _least(y)
    return f"{one}{'' if other.startswith('-') else ' '}{other}"


def _short(numbers: str) -> str:
    """Numbers to a tenth, small ones to a hundredth, without what may be left out between them."""

    def one(found: re.Match[str]) -> str:
        value = float(found[0])
        text = f"{value:.2f}" if abs(value) < 10 else f"{value:.1f}"
        text = text.rstrip("0").rstrip(".")
        return "0" if text in ("-0", "") else text

    text = " ".join(_NUMBER.sub(one, numbers).split())
    return re.sub(r" ?([MLCQZz]) ?", r"\1", text)


def _themed(style: str) -> str:
    """A style in the page's colours; a drawing's own have a brighter one where the page is dark."""

    def one(found: re.Match[str]) -> str:
        colour = found[0]
        if colour in NAMED:
            return f"var(--{NAMED[colour]})"
        return f"var(--{colour[1:]},{colour})" if dark(colour) != colour else colour

    return _COLOUR.sub(one, style.replace(": ", ":").replace("; ", ";"))


def luminance(colour: str) -> float:
    """Relative luminance of #rrggbb, 0 to 1. Source: WCAG 2.2."""
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: str, other: str) -> float:
    """Contrast of two colours, 1 to 21. Source: WCAG 2.2."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def dark(colour: str) -> str:
    """The colour on a dark page: mixed with white until it stands out there; text on bars stays as it is."""
    if colour == ON_COLOUR:
        return colour
    mixed = colour
    for toward in range(1, 20):
        if contrast(mixed, DARK_PAGE) >= LEAST_CONTRAST:
            break
        parts = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
        mixed = "#" + "".join(f"{round(c + (255 - c) * toward / 20):02x}" for c in parts)
    return mixed
