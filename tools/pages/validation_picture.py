"""The picture of the scorecard of docs/validation/: a dot for each case at its measured deviation divided by its limit."""

import html
import math

SMALLEST, LARGEST = 1e-3, 10  # the ends of the logarithmic axis; cases beyond them lie at its ends
LEFT, WIDTH, ROW, TOP = 270, 560, 26, 34


def place(ratio):
    """x of a ratio, which may be 0 or infinite."""
    ratio = min(max(ratio, SMALLEST), LARGEST)
    return LEFT + WIDTH * math.log(ratio / SMALLEST) / math.log(LARGEST / SMALLEST)


def label(x, y, text, anchor):
    return f'<text x="{x:.0f}" y="{y:.0f}" text-anchor="{anchor}">{html.escape(text)}</text>'


def draw(themes):
    """SVG of [(title, [ratio])]."""
    bottom = TOP + ROW * len(themes)
    total = LEFT + WIDTH + 30
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {total} {bottom + 44}" font-family="sans-serif" font-size="13">',
             f'<rect width="{total}" height="{bottom + 44}" fill="white"/>']
    for tick, text in ((1e-3, "≤ 0.001"), (1e-2, "0.01"), (1e-1, "0.1"), (1, "limit"), (10, "≥ 10")):
        x, color = place(tick), "#c00" if tick == 1 else "#ccc"
        lines += [f'<line x1="{x:.1f}" y1="{TOP - 8}" x2="{x:.1f}" y2="{bottom}" stroke="{color}"/>', label(x, TOP - 14, text, "middle")]
    for k, (title, ratios) in enumerate(themes):
        y = TOP + ROW * (k + 0.5)
        met = sum(ratio <= 1 for ratio in ratios)
        lines.append(label(LEFT - 14, y + 4, f"{title}  {met}/{len(ratios)}", "end"))
        for n, ratio in enumerate(sorted(ratios)):
            color = "#c00" if ratio > 1 else "#2667b0"
            lines.append(f'<circle cx="{place(ratio):.1f}" cy="{y + (n % 5 - 2) * 3:.1f}" r="2.6" fill="{color}" fill-opacity="0.6"/>')
    lines += [label(LEFT + WIDTH / 2, bottom + 30, "measured deviation divided by its limit", "middle"), "</svg>"]
    return "\n".join(lines) + "\n"
