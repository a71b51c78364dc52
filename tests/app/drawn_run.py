"""The small run that the tests of pictures look at: a block of water over a sheet of which a part is wet."""

import sys

SCENE = """drench: 1
time: {step: 0.004, end: 0.08}
output: {every: 0.01, surface: true}
fluid: {spacing: 0.02, sources: [{block: {min: [-0.06, 0.03, -0.06], max: [0.06, 0.15, 0.06]}}]}
cloth:
  - mesh: {grid: {size: [0.4, 0.4], nodes: [11, 11]}}
    dynamics: false
    initial_saturation: [{box: {min: [-1, -1, -1], max: [-0.1, 1, 1]}, value: 1.0}]
    porous: {}
"""
LAST = 8  # frame


def expect(good, message):
    if not good:
        sys.exit("%s: %s" % (sys.argv[0].rpartition("/")[2].removesuffix(".py"), message))


def read_file(path):
    with open(path, "rb") as file:
        return file.read()


def is_water(red, green, blue):
    return blue > red + 60 and blue > green + 25 and blue > 120


def is_dark(red, green, blue):
    return max(red, green, blue) < 110 and blue < red + 60
