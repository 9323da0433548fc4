# SPDX-License-Identifier: Apache-2.0
"""Line charts on logarithmic or linear axes as SVG text, without a library; and the same numbers as CSV.

    chart = Chart("title", "triangles", "seconds")          # isLinear=True: both axes are
    chart.Add("prepare", xs, ys)
    chart.Save("docs/images/growth")        # growth.svg and growth.csv
"""

import csv
import html
import math
import pathlib

_PLOT_WIDTH, _HEIGHT = 346, 340
_LEFT, _TOP, _BOTTOM = 64, 34, 46  # margins; the legend stands on the right
_LEGEND, _LETTER = 42, 6.2  # pixels beside the plot before the names, and of a letter
_COLORS = ("#1f5fa8", "#c8501e", "#2e8b57", "#8a4fb0", "#b08a00", "#555555")
_MIN_STEP = 28  # pixels between two labels of an axis
# Of the labels of a logarithmic axis in a decade, finest first.
_FACTORS = (*(tuple(k / 20 for k in range(20, 200, step)) for step in (1, 2, 4, 10)), (1, 1.5, 2, 3, 5, 7), (1, 2, 5), (1,))
_MAX_DOTS = 24  # a line of more points has no dots


def _Number(value: float) -> str:
    """A short label: 0.01, 3, 20 k, 80 M, 4 G."""
    for factor, unit in ((1e9, " G"), (1e6, " M"), (1e3, " k")):
        if abs(value) >= factor:
            return f"{value / factor:.4g}{unit}"
    return f"{value:.4g}"


class _LinearAxis:
    """Maps values to pixels; begins at 0."""

    def __init__(self, values, begin: float, end: float):
        self.high, self.begin, self.end = 1.05 * max(values) or 1.0, begin, end

    def At(self, value: float) -> float:
        return self.begin + value / self.high * (self.end - self.begin)

    def Ticks(self) -> list:
        """Multiples of 1, 2 or 5 times a power of ten."""
        least = self.high * _MIN_STEP * 1.5 / abs(self.end - self.begin)
        decade = 10.0 ** math.floor(math.log10(least))
        step = next(factor * decade for factor in (1, 2, 5, 10) if factor * decade >= least)
        return [step * i for i in range(int(self.high / step) + 1)]


class _Axis:
    """Maps values to pixels by their logarithm."""

    def __init__(self, values, begin: float, end: float):
        low, high = math.log10(min(values)), math.log10(max(values))
        margin = max(0.05 * (high - low), 0.05)
        self.low, self.high, self.begin, self.end = low - margin, high + margin, begin, end

    def At(self, value: float) -> float:
        return self.begin + (math.log10(value) - self.low) / (self.high - self.low) * (self.end - self.begin)

    def Ticks(self) -> list:
        """Powers of ten with as many values between them as have room, without ten where they have not."""
        decades = range(math.floor(self.low), math.ceil(self.high) + 1)
        step = max(1, math.ceil(_MIN_STEP * (self.high - self.low) / abs(self.end - self.begin)))
        for factors in _FACTORS:
            ticks = [factor * 10.0**decade for decade in decades if decade % step == 0 for factor in factors]
            ticks = [tick for tick in ticks if self.low <= math.log10(tick) <= self.high]
            if all(abs(self.At(b) - self.At(a)) >= _MIN_STEP for a, b in zip(ticks, ticks[1:])):
                break
        return ticks


class Chart:
    """Series of points over one x axis. Values that are not above 0 are left out of logarithmic axes."""

    def __init__(self, title: str, xLabel: str, yLabel: str, isLinear: bool = False):
        self.title, self.xLabel, self.yLabel, self.isLinear = title, xLabel, yLabel, isLinear
        self.series = {}

    def Add(self, name: str, xs, ys) -> None:
        self.series[name] = [(float(x), float(y)) for x, y in zip(xs, ys)
                             if y is not None and (self.isLinear or (x > 0 and y > 0))]

    def Save(self, stem) -> None:
        """Writes STEM.svg and STEM.csv."""
        stem = pathlib.Path(stem)
        stem.with_suffix(".svg").write_text(self.Svg())
        with open(stem.with_suffix(".csv"), "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["series", self.xLabel, self.yLabel])
            for name, points in self.series.items():
                writer.writerows([name, f"{x:.6g}", f"{y:.6g}"] for x, y in points)

    def Svg(self) -> str:
        points = [point for series in self.series.values() for point in series]
        right, bottom = _LEFT + _PLOT_WIDTH, _HEIGHT - _BOTTOM
        width = right + _LEGEND + round(_LETTER * max(map(len, self.series)))
        axis = _LinearAxis if self.isLinear else _Axis
        xAxis = axis([x for x, _ in points], _LEFT, right)
        yAxis = axis([y for _, y in points], bottom, _TOP)
        parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{_HEIGHT}" '
                 f'viewBox="0 0 {width} {_HEIGHT}" font-family="sans-serif" font-size="11" fill="#222222">',
                 f'<rect width="{width}" height="{_HEIGHT}" fill="#ffffff"/>',
                 self._Text((_LEFT + right) / 2, 18, self.title, 'text-anchor="middle" font-size="13"')]
        for tick in xAxis.Ticks():
            x = xAxis.At(tick)
            parts.append(f'<path d="M{x:.1f} {_TOP}V{bottom}" stroke="#dddddd"/>')
            parts.append(self._Text(x, bottom + 16, _Number(tick), 'text-anchor="middle"'))
        for tick in yAxis.Ticks():
            y = yAxis.At(tick)
            parts.append(f'<path d="M{_LEFT} {y:.1f}H{right}" stroke="#dddddd"/>')
            parts.append(self._Text(_LEFT - 6, y + 4, _Number(tick), 'text-anchor="end"'))
        parts.append(f'<path d="M{_LEFT} {_TOP}V{bottom}H{right}" fill="none" stroke="#222222"/>')
        parts.append(self._Text((_LEFT + right) / 2, _HEIGHT - 10, self.xLabel, 'text-anchor="middle"'))
        parts.append(self._Text(0, 0, self.yLabel,
                                f'text-anchor="middle" transform="translate(14 {(_TOP + bottom) / 2}) rotate(-90)"'))
        for i, (name, series) in enumerate(self.series.items()):
            parts += self._Line(i, name, [(xAxis.At(x), yAxis.At(y)) for x, y in series], right)
        return "\n".join(parts + ["</svg>", ""])

    @staticmethod
    def _Text(x: float, y: float, text: str, attributes: str = "") -> str:
        return f'<text x="{x:.1f}" y="{y:.1f}" {attributes}>{html.escape(text)}</text>'

    def _Line(self, i: int, name: str, pixels: list, right: float) -> list:
        color = _COLORS[i % len(_COLORS)]
        dash = "" if i < len(_COLORS) else ' stroke-dasharray="5 3"'
        line = " ".join(f"{x:.1f},{y:.1f}" for x, y in pixels)
        legend = _TOP + 12 + 18 * i
        return [f'<polyline points="{line}" fill="none" stroke="{color}" stroke-width="2"{dash}/>',
                *(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{color}"/>'
                  for x, y in (pixels if len(pixels) <= _MAX_DOTS else ())),
                f'<path d="M{right + 12} {legend - 4}h18" stroke="{color}" stroke-width="2"{dash}/>',
                self._Text(right + 35, legend, name)]
