"""Colours of figures and 3D scenes, distinguishable with most colour vision deficiencies.

Source: Okabe and Ito 2008, "Color Universal Design".
"""

from __future__ import annotations

from typing import TypeAlias

Colour: TypeAlias = tuple[float, float, float]  # sRGB, each in [0, 1]

BLUE = "#0072b2"
VERMILION = "#d55e00"
GREEN = "#009e73"
AMBER = "#e69f00"
PINK = "#cc79a7"
SKY = "#56b4e9"
BLACK = "#1d2733"
GREY = "#8a94a0"

CYCLE = (BLUE, VERMILION, GREEN, AMBER, PINK, SKY, GREY, BLACK)
LIGHT_AND_DARK = CYCLE[:-1]  # those that are seen on a white and on a black page

DEMONSTRATION = GREY
PATH = BLUE
DETOUR = VERMILION
OBSTACLE = "#4b5563"
GOAL = GREEN
SHELL = "#e7e9ec"
JOINT = "#7d8fa3"
TOOL = AMBER


def rgb(colour: str) -> Colour:
    """Red, green and blue of a colour such as "#0072b2"."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    return red, green, blue
