# SPDX-License-Identifier: Apache-2.0
"""A drawing as SVG and as PNG."""

from io import BytesIO
from xml.sax.saxutils import escape

from PIL import Image, ImageDraw, ImageFont

from rocsafe_planner.export.plan_drawing import Dot, Drawing, Label, Shape

# Drawn larger and scaled down, because Pillow draws lines without anti-aliasing.
_OVERSAMPLING = 2


def drawing_svg(drawing: Drawing) -> str:
    """Return the drawing as an SVG 1.1 document."""
    size = f'width="{drawing.width_px}" height="{drawing.height_px}"'
    view = f'viewBox="0 0 {drawing.width_px} {drawing.height_px}"'
    body = '\n'.join(_svg(mark) for mark in drawing.marks)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} {view} font-family="sans-serif">\n'
        f'<rect width="100%" height="100%" fill="#ffffff"/>\n{body}\n</svg>\n'
    )


def drawing_png(drawing: Drawing) -> bytes:
    """Return the drawing as a PNG image."""
    size = (_OVERSAMPLING * drawing.width_px, _OVERSAMPLING * drawing.height_px)
    image = Image.new('RGB', size, '#ffffff')
    pen = ImageDraw.Draw(image, 'RGBA')
    for mark in drawing.marks:
        _paint(pen, mark)
    content = BytesIO()
    image.resize((drawing.width_px, drawing.height_px), Image.Resampling.LANCZOS).save(
        content, 'PNG', compress_level=6
    )
    return content.getvalue()


def _svg(mark: Shape | Dot | Label) -> str:
    if isinstance(mark, Dot):
        x, y = mark.centre
        return f'<circle cx="{x:g}" cy="{y:g}" r="{mark.radius:g}" fill="{mark.fill}"/>'
    if isinstance(mark, Label):
        x, y = mark.place
        place = f'x="{x:g}" y="{y:g}" font-size="{mark.size}" fill="{mark.color}"'
        return f'<text {place}>{escape(mark.text)}</text>'
    tag = 'polygon' if mark.is_closed else 'polyline'
    points = ' '.join(f'{x:g},{y:g}' for x, y in mark.points)
    ink = f'fill="{mark.fill or "none"}" stroke="{mark.stroke or "none"}"'
    return (
        f'<{tag} points="{points}" {ink} stroke-width="{mark.width:g}" '
        f'fill-opacity="{mark.opacity:g}" stroke-linejoin="round"/>'
    )


def _paint(pen: ImageDraw.ImageDraw, mark: Shape | Dot | Label) -> None:
    scale = _OVERSAMPLING
    if isinstance(mark, Dot):
        x, y = (scale * value for value in mark.centre)
        radius = scale * mark.radius
        pen.ellipse((x - radius, y - radius, x + radius, y + radius), fill=mark.fill)
    elif isinstance(mark, Label):
        x, y = (scale * value for value in mark.place)
        font = ImageFont.load_default(scale * mark.size)
        pen.text((x, y), mark.text, fill=mark.color, font=font, anchor='ls')
    else:
        points = [(scale * x, scale * y) for x, y in mark.points]
        if mark.fill:
            pen.polygon(points, fill=f'{mark.fill}{round(255 * mark.opacity):02x}')
        if mark.stroke:
            track = [*points, points[0]] if mark.is_closed else points
            width = max(1, round(scale * mark.width))
            pen.line(track, fill=mark.stroke, width=width, joint='curve')
